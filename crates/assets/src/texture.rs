//! Decodes images, once for each way they are read, and makes textures of them.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

use ergodic_scattering::{Interpolation, Texels, Texture, TextureUse, Wrap};
use glam::{DAffine2, DMat2, DVec2};
use gltf::json::texture::{MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{self, Index, extensions::texture::TextureTransform};
use image::{DynamicImage, ImageReader};

use crate::document::{Document, get};
use crate::error::{Flaw, Trouble};
use crate::warnings::Warnings;
use crate::{limits, uri};

/// What the numbers in an image mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Encoding {
    /// Colour, in sRGB.
    Srgb,
    /// Anything else.
    Linear,
}

/// A reference to a texture, as the several structures of the JSON have it.
pub(crate) struct Reference<'a> {
    pub texture: Index<json::Texture>,
    pub texcoord: u32,
    pub transform: Option<&'a TextureTransform>,
    pub encoding: Encoding,
}

/// The textures in use so far.
#[derive(Default)]
pub(crate) struct Textures {
    pub textures: Vec<Texture>,
    known: HashMap<(usize, Encoding), usize>,
    decoded: HashMap<(usize, Encoding), Arc<Picture>>,
    bytes: u64,
}

struct Picture {
    width: u32,
    height: u32,
    texels: Texels,
}

impl Textures {
    /// The use of a texture that a reference describes; `None`, with a warning, if its coordinates are not read.
    pub(crate) fn reference(
        &mut self,
        document: &Document,
        reference: &Reference<'_>,
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<TextureUse>, Flaw> {
        let transform = reference.transform;
        let texcoord = transform.and_then(|t| t.tex_coord).unwrap_or(reference.texcoord) as usize;
        if texcoord > 1 {
            warnings.note("Textures with a third set of coordinates", place, "are not read");
            return Ok(None);
        }
        let texture = self.texture(document, reference.texture, reference.encoding, place)?;
        let transform = match transform {
            Some(transform) => affine(transform, place)?,
            None => DAffine2::IDENTITY,
        };
        Ok(Some(TextureUse { texture, texcoord, transform }))
    }

    fn texture(
        &mut self,
        document: &Document,
        index: Index<json::Texture>,
        encoding: Encoding,
        place: &str,
    ) -> Result<usize, Flaw> {
        let key = (index.value(), encoding);
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let texture = get(&document.root.textures, index, "textures", place)?;
        let place = format!("textures[{}]", index.value());
        let source = source(document, texture, &place)?;
        let picture = self.picture(document, source, encoding)?;
        let mut sampler = None;
        if let Some(index) = texture.sampler {
            sampler = Some(get(&document.root.samplers, index, "samplers", &format!("{place}.sampler"))?);
        }
        let wrap = |mode: Option<Checked<WrappingMode>>| match mode {
            Some(Checked::Valid(WrappingMode::ClampToEdge)) => Wrap::ClampToEdge,
            Some(Checked::Valid(WrappingMode::MirroredRepeat)) => Wrap::MirroredRepeat,
            _ => Wrap::Repeat,
        };
        let nearest = matches!(sampler.and_then(|s| s.mag_filter), Some(Checked::Valid(MagFilter::Nearest)));
        self.textures.push(Texture {
            width: picture.width,
            height: picture.height,
            texels: picture.texels.clone(),
            wrap_u: wrap(sampler.map(|s| s.wrap_s)),
            wrap_v: wrap(sampler.map(|s| s.wrap_t)),
            interpolation: if nearest { Interpolation::Nearest } else { Interpolation::Bilinear },
        });
        self.known.insert(key, self.textures.len() - 1);
        Ok(self.textures.len() - 1)
    }

    fn picture(&mut self, document: &Document, source: usize, encoding: Encoding) -> Result<Arc<Picture>, Flaw> {
        if let Some(known) = self.decoded.get(&(source, encoding)) {
            return Ok(known.clone());
        }
        let place = format!("images[{source}]");
        let picture = decode(&image_bytes(document, source, &place)?, encoding, &place)?;
        self.bytes += picture.texels.bytes();
        if self.bytes > limits::ALL_IMAGE_BYTES {
            let problem = format!("is where the textures exceed {} bytes", limits::ALL_IMAGE_BYTES);
            return Err(Flaw::new(Trouble::TooLarge, place, problem, "Use smaller textures"));
        }
        let picture = Arc::new(picture);
        self.decoded.insert((source, encoding), picture.clone());
        Ok(picture)
    }
}

/// The image a texture shows; one that an understood extension names goes before the fallback.
fn source(document: &Document, texture: &json::Texture, place: &str) -> Result<usize, Flaw> {
    let others = texture.extensions.as_ref().map(|e| &e.others);
    let webp = others.and_then(|o| o.get("EXT_texture_webp")?.get("source")?.as_u64());
    let missing = texture.source.value() == u32::MAX as usize;
    let index = match webp {
        Some(index) => usize::try_from(index).unwrap_or(usize::MAX),
        None if missing => {
            if let Some((name, _)) = others.and_then(|o| o.iter().next()) {
                return Err(crate::extensions::unsupported(place, name));
            }
            return Err(Flaw::malformed(place, "has no source"));
        }
        None => texture.source.value(),
    };
    let count = document.root.images.len();
    if index < count { Ok(index) } else { Err(Flaw::dangling(format!("{place}.source"), "images", index, count)) }
}

/// The bytes of an image that there is.
fn image_bytes<'a>(document: &'a Document, source: usize, place: &str) -> Result<Cow<'a, [u8]>, Flaw> {
    let image = &document.root.images[source];
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => uri::resolve(uri, document.folder.as_deref(), &format!("{place}.uri")).map(Cow::Owned),
        (None, Some(view)) => document.view(view, &format!("{place}.bufferView")).map(Cow::Borrowed),
        (None, None) => Err(Flaw::malformed(place, "has neither a uri nor a bufferView")),
    }
}

/// Decodes an image that a structure at `user` refers to by its index.
pub(crate) fn image(document: &Document, index: usize, user: &str) -> Result<DynamicImage, Flaw> {
    let count = document.root.images.len();
    if index >= count {
        return Err(Flaw::dangling(user, "images", index, count));
    }
    let place = format!("images[{index}]");
    pixels(&image_bytes(document, index, &place)?, &place)
}

fn pixels(bytes: &[u8], place: &str) -> Result<DynamicImage, Flaw> {
    let mend = "Store the image as PNG, JPEG or WebP";
    let broken = |e: image::ImageError| {
        let trouble = if matches!(e, image::ImageError::Limits(_)) { Trouble::TooLarge } else { Trouble::Malformed };
        Flaw::new(trouble, place, format!("cannot be decoded: {e}"), mend)
    };
    // What the bytes are decides, not what the file calls them.
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|e| Flaw::new(Trouble::Malformed, place, format!("cannot be decoded: {e}"), mend))?;
    let mut bounds = image::Limits::default();
    bounds.max_image_width = Some(limits::IMAGE_SIDE);
    bounds.max_image_height = Some(limits::IMAGE_SIDE);
    bounds.max_alloc = Some(limits::IMAGE_BYTES);
    reader.limits(bounds);
    let image = reader.decode().map_err(broken)?;
    if image.width() == 0 || image.height() == 0 {
        return Err(Flaw::malformed(place, "has no pixels"));
    }
    Ok(image)
}

fn decode(bytes: &[u8], encoding: Encoding, place: &str) -> Result<Picture, Flaw> {
    let image = pixels(bytes, place)?;
    let (width, height) = (image.width(), image.height());
    let texels = match (&image, encoding) {
        (
            DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_),
            Encoding::Linear,
        ) => Texels::Float(image.to_rgba32f().pixels().map(|p| p.0).collect()),
        (_, Encoding::Linear) => Texels::Linear8(image.to_rgba8().pixels().map(|p| p.0).collect()),
        (_, Encoding::Srgb) => Texels::Srgb8(image.to_rgba8().pixels().map(|p| p.0).collect()),
    };
    Ok(Picture { width, height, texels })
}

/// KHR_texture_transform: translation * rotation * scale; the rotation is counter-clockwise as seen with v upwards.
fn affine(transform: &TextureTransform, place: &str) -> Result<DAffine2, Flaw> {
    let [x, y] = transform.offset.0.map(f64::from);
    let [sx, sy] = transform.scale.0.map(f64::from);
    let (sin, cos) = libm::sincos(f64::from(transform.rotation.0));
    let rotation = DMat2::from_cols(DVec2::new(cos, -sin), DVec2::new(sin, cos));
    let matrix = rotation * DMat2::from_diagonal(DVec2::new(sx, sy));
    let affine = DAffine2 { matrix2: matrix, translation: DVec2::new(x, y) };
    if affine.is_finite() {
        Ok(affine)
    } else {
        Err(Flaw::malformed(format!("{place}.extensions.KHR_texture_transform"), "is not finite"))
    }
}
