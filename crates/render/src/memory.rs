//! How much memory a render takes at most.

use ergodic_pathspace::{Edge, Vertex};

use crate::autocorrelation::{WATCHED, Windows};
use crate::bins::CAPACITY;
use crate::film::{FILM_BYTES_PER_PIXEL, PICTURE_BYTES_PER_PIXEL};
use crate::grid::Grid;
use crate::seeding::KEPT;
use crate::starts::Seed;
use crate::statistics::MutationStatistics;
use crate::{BATCHES, Coordinates, Method, Settings, SplatBuffer, VisitBuffer, layers};

/// Bytes that a render takes at most, the scene, its textures and the stacks of the threads left out.
///
/// What grows with the picture is one film of 48 bytes a pixel, the picture of 24 and another 24 while the film is developed.
/// What grows with the number of batches does not depend on the size of the picture. Nothing grows with the number of threads.
/// `mlt.layers` takes another 48 bytes a pixel and 8 for each of the parts that the standard error comes from, which take a
/// gibibyte at most, or 32 bytes a pixel if that is more.
pub fn peak_bytes(settings: &Settings) -> usize {
    let (width, height) = settings.film_size();
    let grid = Grid::new(width, height, settings.filter.filter());
    let mut pixel = FILM_BYTES_PER_PIXEL + 2 * PICTURE_BYTES_PER_PIXEL;
    // The last sample, or the last look at the chains, may need more room than is left.
    let chains_of_batch = settings.mlt.chains.div_ceil(BATCHES);
    let mut batch = SplatBuffer::bytes(CAPACITY + settings.max_edges, &grid);
    let mut fixed = 0;
    if settings.method.has_chains() {
        if settings.mlt.layers {
            pixel += layers::bytes_per_pixel(layers::parts(grid.pixels()));
            // A vector that grows holds twice what it needs.
            batch += VisitBuffer::bytes(2 * CAPACITY.max(chains_of_batch), &grid);
        }
        let mutations = if settings.method == Method::Mlt { settings.mlt.mutations.len() } else { 2 };
        batch += mutations * MutationStatistics::bytes(settings.max_edges);
        // Two paths for every chain, the present one and the candidate; of a primary sample, two walks each and its coordinates.
        let vertices = (settings.max_edges + 1) * (size_of::<Vertex>() + size_of::<Edge>());
        let state = if settings.method == Method::Mlt {
            vertices
        } else {
            2 * vertices + Coordinates::bytes(settings.max_edges)
        };
        fixed += settings.mlt.chains * 2 * state + settings.mlt.chains.min(WATCHED) * size_of::<Windows>();
        // A list of seeds that grows has its old place and one of twice the size; one that is thinned has its running sum, those that
        // are kept and their positions beside it.
        fixed += (3 * size_of::<Seed>() + 2 * size_of::<f64>() + size_of::<usize>()) * KEPT / 2;
    }
    pixel * grid.pixels() + batch * BATCHES + fixed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FilterSettings;

    const GIB: usize = 1 << 30;

    fn settings(size: (u32, u32), layers: bool) -> Settings {
        let filter = FilterSettings::Gaussian { radius: 2.0, sigma: 0.5 };
        let mut settings = Settings { size, filter, ..Settings::default() };
        settings.mlt.layers = layers;
        settings
    }

    #[test]
    fn a_4k_picture_on_64_threads_takes_less_than_4_gib() {
        let (size, pixels) = ((3840, 2160), 3840 * 2160);
        for (layers, most) in [(false, 5 * GIB / 4), (true, 3 * GIB)] {
            let bytes = peak_bytes(&settings(size, layers));
            println!("3840x2160, layers {layers}: {:.2} GiB", bytes as f64 / GIB as f64);
            assert!(bytes < most, "{bytes}");
            assert!(bytes > pixels * 96);
        }
        // Work for 64 threads, both where there are batches and where there are bands.
        let grid = Grid::new(size.0, size.1, FilterSettings::Box.filter());
        assert!(grid.bands() >= 2 * 64 && BATCHES.min(size.1 as usize) >= 2 * 64);
        // A film for each of 64 batches would be far beyond the bound.
        assert!(64 * pixels * FILM_BYTES_PER_PIXEL > 20 * GIB);
    }

    #[test]
    fn memory_per_pixel_does_not_grow_with_the_picture() {
        for layers in [false, true] {
            let bytes = |size| peak_bytes(&settings(size, layers)) as f64;
            // 16 times the pixels.
            let (small, large) = (bytes((1920, 1080)), bytes((7680, 4320)));
            println!("layers {layers}: {:.2} GiB, {:.2} GiB", small / GIB as f64, large / GIB as f64);
            assert!(large < 16.0 * small);
            assert!(large / f64::from(7680 * 4320) < if layers { 192.0 } else { 110.0 });
        }
        let chains = |chains| {
            let mut settings = settings((256, 256), true);
            settings.mlt.chains = chains;
            peak_bytes(&settings)
        };
        assert!(chains(1 << 20) > chains(512), "chains are counted");
    }
}
