//! The colour spaces of FLIP. All linear RGB here is that of sRGB.

/// From linear sRGB to XYZ, with the primaries and white point D65 of IEC 61966-2-1.
const RGB_TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

fn multiply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Solves `m x = v` by Cramer's rule.
fn solve(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    let column = |i: usize| [m[0][i], m[1][i], m[2][i]];
    let (a, b, c) = (column(0), column(1), column(2));
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let determinant = dot(a, cross(b, c));
    [dot(v, cross(b, c)) / determinant, dot(a, cross(v, c)) / determinant, dot(a, cross(b, v)) / determinant]
}

/// XYZ relative to white.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let white = multiply(&RGB_TO_XYZ, [1.0; 3]);
    let xyz = multiply(&RGB_TO_XYZ, rgb);
    [0, 1, 2].map(|i| xyz[i] / white[i])
}

/// The opponent space Y Cx Cz, linear in RGB.
pub(super) fn to_ycxcz(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Back to linear RGB.
pub(super) fn from_ycxcz([luma, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (luma + 16.0) / 116.0;
    let (x, z) = (cx / 500.0 + y, y - cz / 200.0);
    let white = multiply(&RGB_TO_XYZ, [1.0; 3]);
    solve(&RGB_TO_XYZ, [x * white[0], y * white[1], z * white[2]])
}

/// CIE L*a*b* with a* and b* weighed by lightness (the Hunt effect).
pub(super) fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let f = |t: f64| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = relative_xyz(rgb).map(f);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The distance HyAB: city block between lightness and colour, Euclidean within colour.
pub(super) fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_opponent_space_is_invertible_and_grey_has_no_colour() {
        for rgb in [[0.2, 0.5, 0.9], [1.0, 0.0, 0.0], [0.0; 3]] {
            let back = from_ycxcz(to_ycxcz(rgb));
            assert!(rgb.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12), "{back:?}");
        }
        let [luma, cx, cz] = to_ycxcz([1.0; 3]);
        assert!((luma - 100.0).abs() < 1e-12 && cx.abs() < 1e-12 && cz.abs() < 1e-12);
    }
}
