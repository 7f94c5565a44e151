//! Reads accessors: typed arrays in buffers, dense or sparse (glTF 2.0, section 3.6.2).

use glam::{DAffine3, DMat3, DVec3};
use gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer};

use crate::document::{Document, get};
use crate::error::{Flaw, Trouble};
use crate::limits;

/// An accessor whose shape has been checked.
pub(crate) struct Layout {
    component: ComponentType,
    components: usize,
    normalized: bool,
    count: usize,
}

impl Layout {
    fn element_bytes(&self) -> usize {
        self.component.size() * self.components
    }

    /// The value of one component, dequantized if normalized (section 3.6.2.2).
    fn value(&self, bytes: &[u8]) -> f64 {
        let value = match (self.component, bytes) {
            (ComponentType::I8, &[a]) => f64::from(a as i8),
            (ComponentType::U8, &[a]) => f64::from(a),
            (ComponentType::I16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
            (ComponentType::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
            (ComponentType::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (ComponentType::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => f64::NAN,
        };
        self.dequantized(value)
    }

    /// What a stored number of the accessor's component type stands for.
    pub(crate) fn dequantized(&self, value: f64) -> f64 {
        let scale = match self.component {
            ComponentType::I8 => 127.0,
            ComponentType::U8 => 255.0,
            ComponentType::I16 => 32_767.0,
            ComponentType::U16 => 65_535.0,
            ComponentType::U32 => 4_294_967_295.0,
            ComponentType::F32 => return value,
        };
        if self.normalized { (value / scale).max(-1.0) } else { value }
    }

    /// How many elements there are.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// How many numbers an element has.
    pub(crate) fn components(&self) -> usize {
        self.components
    }
}

fn components_of(kind: Type) -> Option<usize> {
    match kind {
        Type::Scalar => Some(1),
        Type::Vec2 => Some(2),
        Type::Vec3 => Some(3),
        Type::Vec4 => Some(4),
        Type::Mat4 => Some(16),
        Type::Mat2 | Type::Mat3 => None,
    }
}

/// Rows of up to four numbers, as an accessor has them; unused ones are `fill`.
pub(crate) struct Rows {
    pub rows: Vec<[f64; 4]>,
}

/// Reads an accessor of vectors with a number of components that `allowed` lists. What is missing is filled with `fill`.
pub(crate) fn vectors(
    document: &Document,
    index: Index<Accessor>,
    allowed: &[usize],
    fill: f64,
    place: &str,
) -> Result<Rows, Flaw> {
    elements(document, index, allowed, fill, place).map(|rows| Rows { rows })
}

/// Reads an accessor of affine 4x4 matrices of floating-point numbers, column by column.
pub(crate) fn matrices(document: &Document, index: Index<Accessor>, place: &str) -> Result<Vec<DAffine3>, Flaw> {
    let (layout, own_place) = layout(document, index, &[16], place)?;
    if !matches!(layout.component, ComponentType::F32) {
        return Err(Flaw::malformed(format!("{own_place}.componentType"), "is used for matrices, which are floats"));
    }
    let column = |m: &[f64; 16], i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
    let rows = elements::<16>(document, index, &[16], 0.0, place)?;
    let affine = |m: &[f64; 16]| DAffine3 {
        matrix3: DMat3::from_cols(column(m, 0), column(m, 1), column(m, 2)),
        translation: column(m, 3),
    };
    Ok(rows.iter().map(affine).collect())
}

/// The shape of an accessor, checked, and the accessor's place in the file.
pub(crate) fn layout(
    document: &Document,
    index: Index<Accessor>,
    allowed: &[usize],
    place: &str,
) -> Result<(Layout, String), Flaw> {
    let accessor = get(&document.root.accessors, index, "accessors", place)?;
    let place = format!("accessors[{}]", index.value());
    layout_of(accessor, allowed, &place).map(|layout| (layout, place))
}

/// An accessor's elements of up to `N` numbers.
fn elements<const N: usize>(
    document: &Document,
    index: Index<Accessor>,
    allowed: &[usize],
    fill: f64,
    place: &str,
) -> Result<Vec<[f64; N]>, Flaw> {
    let accessor = get(&document.root.accessors, index, "accessors", place)?;
    let (layout, place) = layout(document, index, allowed, place)?;
    if accessor.buffer_view.is_none() && accessor.count.0 > limits::VIEWLESS_ELEMENTS {
        let problem = format!("has {} elements without a bufferView to hold them", accessor.count.0);
        return Err(Flaw::new(Trouble::TooLarge, place, problem, "Store the elements in a bufferView"));
    }
    let n = layout.components;
    let size = layout.component.size();
    let mut rows;
    if let Some(view) = accessor.buffer_view {
        let (bytes, stride) = span(document, view, accessor.byte_offset.map_or(0, |o| o.0), &layout, &place)?;
        rows = vec![[fill; N]; layout.count];
        for (row, element) in rows.iter_mut().zip(bytes.chunks(stride)) {
            for (value, component) in row.iter_mut().zip(element.chunks_exact(size)).take(n) {
                *value = layout.value(component);
            }
        }
    } else {
        rows = vec![[fill; N]; layout.count];
        rows.iter_mut().for_each(|row| row[..n].fill(0.0));
    }
    if let Some(sparse) = &accessor.sparse {
        let place = format!("{place}.sparse");
        let Checked::Valid(kind) = sparse.indices.component_type else {
            return Err(Flaw::malformed(format!("{place}.indices.componentType"), "is no type that indices have"));
        };
        let count = element_count(sparse.count.0, &place)?;
        if count > layout.count {
            let problem = format!("replaces {count} elements of {}", layout.count);
            return Err(Flaw::malformed(place, problem));
        }
        let of_indices = Layout { component: kind.0, components: 1, normalized: false, count };
        let of_values = Layout { count, ..layout };
        let (indices, index_stride) =
            span(document, sparse.indices.buffer_view, sparse.indices.byte_offset.0, &of_indices, &place)?;
        let (values, stride) =
            span(document, sparse.values.buffer_view, sparse.values.byte_offset.0, &of_values, &place)?;
        for (i, (index, element)) in indices.chunks(index_stride).zip(values.chunks(stride)).enumerate() {
            let at = of_indices.value(&index[..kind.0.size()]);
            let total = rows.len();
            let row = rows.get_mut(at as usize).ok_or_else(|| {
                Flaw::malformed(&place, format!("index {i} is {at}, but the accessor has {total} elements"))
            })?;
            for (value, component) in row.iter_mut().zip(element.chunks_exact(size)).take(n) {
                *value = of_values.value(component);
            }
        }
    }
    usable(&rows, n, &place)?;
    Ok(rows)
}

/// Whether the first `n` numbers of every row can be computed with.
pub(crate) fn usable<const N: usize>(rows: &[[f64; N]], n: usize, place: &str) -> Result<(), Flaw> {
    for (i, row) in rows.iter().enumerate() {
        if let Some(bad) = row[..n].iter().find(|v| v.is_nan() || v.abs() > limits::COORDINATE) {
            return Err(Flaw::malformed(place, format!("element {i} holds {bad}, which is no usable number")));
        }
    }
    Ok(())
}

/// Reads an accessor of vertex indices.
pub(crate) fn indices(document: &Document, index: Index<Accessor>, place: &str) -> Result<Vec<u32>, Flaw> {
    let accessor = get(&document.root.accessors, index, "accessors", place)?;
    if let Checked::Valid(GenericComponentType(kind)) = accessor.component_type
        && (!matches!(kind, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) || accessor.normalized)
    {
        let place = format!("accessors[{}].componentType", index.value());
        return Err(Flaw::malformed(place, "is used for indices, which are unsigned integers"));
    }
    let Rows { rows } = vectors(document, index, &[1], 0.0, place)?;
    Ok(rows.into_iter().map(|[i, ..]| i as u32).collect())
}

fn layout_of(accessor: &Accessor, allowed: &[usize], place: &str) -> Result<Layout, Flaw> {
    let Checked::Valid(GenericComponentType(component)) = accessor.component_type else {
        return Err(Flaw::malformed(format!("{place}.componentType"), "is not one of glTF's component types"));
    };
    let Checked::Valid(kind) = accessor.type_ else {
        return Err(Flaw::malformed(format!("{place}.type"), "is not one of glTF's accessor types"));
    };
    let components = components_of(kind).filter(|n| allowed.contains(n)).ok_or_else(|| {
        let allowed = allowed.iter().map(ToString::to_string).collect::<Vec<_>>().join(" or ");
        Flaw::malformed(format!("{place}.type"), format!("is {kind:?} where {allowed} components are needed"))
    })?;
    let count = element_count(accessor.count.0, place)?;
    Ok(Layout { component, components, normalized: accessor.normalized, count })
}

fn element_count(count: u64, place: &str) -> Result<usize, Flaw> {
    let problem = || Flaw::new(Trouble::TooLarge, place, format!("has {count} elements"), "Split the mesh");
    usize::try_from(count).ok().filter(|&n| n <= u32::MAX as usize).ok_or_else(problem)
}

/// The bytes from the first element to the last, and the distance between two.
fn span<'a>(
    document: &'a Document,
    index: Index<buffer::View>,
    offset: u64,
    layout: &Layout,
    place: &str,
) -> Result<(&'a [u8], usize), Flaw> {
    let bytes = document.view(index, &format!("{place}.bufferView"))?;
    let element = layout.element_bytes();
    let stride = document.root.buffer_views[index.value()].byte_stride.map_or(element, |s| s.0);
    if stride < element {
        let problem = format!("has a stride of {stride} bytes for elements of {element} bytes");
        return Err(Flaw::malformed(format!("bufferViews[{}].byteStride", index.value()), problem));
    }
    if layout.count == 0 {
        return Ok((&[], stride));
    }
    let length = (layout.count - 1).checked_mul(stride).and_then(|n| n.checked_add(element));
    let span = length.and_then(|length| {
        let start = usize::try_from(offset).ok()?;
        bytes.get(start..start.checked_add(length)?)
    });
    let span = span.ok_or_else(|| {
        let (count, total) = (layout.count, bytes.len());
        let problem = format!(
            "has {count} elements of {element} bytes from byte {offset} with a stride of {stride}, but its bufferView has only {total} bytes"
        );
        Flaw::malformed(place, problem)
    })?;
    Ok((span, stride))
}
