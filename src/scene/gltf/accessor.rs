//! Accessors: typed elements in buffer views, checked once and then read at random.

use super::buffers::Buffers;
use super::document::{Document, item};
use super::error::{Fault, Kind, Result, Within};
use super::views::Component;
use gltf::json;
use json::accessor::{ComponentType, Type, sparse};
use json::validation::Checked;
use std::ops::RangeInclusive;

/// Elements that an accessor without bytes of its own may claim before they count as out of proportion.
const LARGEST_ZERO_FILL: u64 = 1 << 16;

/// An accessor whose every element is known to lie within its bytes.
pub struct Reader<'a> {
    /// Number of elements.
    pub count: usize,
    components: usize,
    normalized: bool,
    base: Packed<'a>,
    sparse: Option<Sparse<'a>>,
}

/// Equally spaced elements; none where the accessor starts as zeros.
struct Packed<'a> {
    bytes: &'a [u8],
    stride: usize,
    component: Component,
}

/// Elements that deviate, by rising index.
struct Sparse<'a> {
    count: usize,
    indices: Packed<'a>,
    values: Packed<'a>,
}

/// Little-endian numbers without gaps that stand for an accessor.
pub struct Decompressed {
    pub bytes: Vec<u8>,
    /// Unsigned 32-bit integers rather than 32-bit floats.
    pub integers: bool,
    /// Numbers an element.
    pub components: usize,
}

impl<'a> Reader<'a> {
    /// Opens an accessor whose elements have a number of components in `components`.
    pub fn open(
        document: &'a Document,
        buffers: &'a Buffers<'_>,
        index: usize,
        components: RangeInclusive<usize>,
    ) -> Result<Self> {
        let accessor = item(&document.accessors, "accessor", index)?;
        if let Some(values) = buffers.decompressed(index) {
            fits(&components, values.components)?;
            return Ok(Self::of_decompressed(values));
        }
        let (component, found) = layout(accessor, components.contains(&16))?;
        fits(&components, found)?;
        let count = accessor.count.0;
        let size = found * component.size();
        let base = match accessor.buffer_view {
            Some(view) => {
                packed(buffers, view.value(), accessor.byte_offset.map_or(0, |o| o.0), count, size, component)?
            }
            None => zeros(count, buffers, component)?,
        };
        let sparse = accessor.sparse.as_ref().map(|s| open_sparse(s, buffers, count, size, component));
        let sparse = sparse.transpose().within(|| "sparse")?;
        Ok(Self { count: count as usize, components: found, normalized: accessor.normalized, base, sparse })
    }

    fn of_decompressed(values: &'a Decompressed) -> Self {
        let component = if values.integers { Component::U32 } else { Component::F32 };
        let stride = (values.components * component.size()).max(1);
        let base = Packed { bytes: &values.bytes, stride, component };
        let count = values.bytes.len() / stride;
        Self { count, components: values.components, normalized: false, base, sparse: None }
    }

    /// Refuses signed and floating components: `use_` needs unsigned integers.
    pub fn require_unsigned(self, use_: &str) -> Result<Self> {
        match self.base.component {
            Component::U8 | Component::U16 | Component::U32 => Ok(self),
            other => Err(Fault::invalid(format!("has components of type {other:?}; {use_} are unsigned integers"))),
        }
    }

    /// Element `index < count`; components that the accessor lacks are zero.
    pub fn get<const N: usize>(&self, index: usize) -> [f32; N] {
        let mut out = [0.0; N];
        let Some((bytes, component)) = self.element(index) else { return out };
        for (i, value) in out.iter_mut().enumerate().take(self.components) {
            *value = component.to_f32(&bytes[i * component.size()..], self.normalized);
        }
        out
    }

    /// Element `index < count` of unsigned integers.
    pub fn get_index(&self, index: usize) -> u32 {
        self.element(index).map_or(0, |(bytes, component)| component.to_u32(bytes))
    }

    /// The unsigned integers of element `index < count`.
    pub fn get_indices<const N: usize>(&self, index: usize) -> [u32; N] {
        let Some((bytes, component)) = self.element(index) else { return [0; N] };
        let read = |i| if i < self.components { component.to_u32(&bytes[i * component.size()..]) } else { 0 };
        std::array::from_fn(read)
    }

    /// Number of components of an element.
    pub fn components(&self) -> usize {
        self.components
    }

    fn element(&self, index: usize) -> Option<(&[u8], Component)> {
        let component = self.base.component;
        if let Some(sparse) = &self.sparse
            && let Some(place) = sparse.find(index as u32)
        {
            return Some((&sparse.values.bytes[place * sparse.values.stride..], component));
        }
        (!self.base.bytes.is_empty()).then(|| (&self.base.bytes[index * self.base.stride..], component))
    }
}

impl Sparse<'_> {
    fn index(&self, place: usize) -> u32 {
        self.indices.component.to_u32(&self.indices.bytes[place * self.indices.stride..])
    }

    fn find(&self, index: u32) -> Option<usize> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = (low + high) / 2;
            match self.index(middle).cmp(&index) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
                std::cmp::Ordering::Equal => return Some(middle),
            }
        }
        None
    }
}

fn fits(wanted: &RangeInclusive<usize>, found: usize) -> Result<()> {
    if wanted.contains(&found) {
        return Ok(());
    }
    let wanted = wanted.start();
    Err(Fault::invalid(format!("has {found} components an element where {wanted} are needed")))
}

/// Component and number of components of an element; of 4 × 4 matrices only where `matrices` are wanted.
fn layout(accessor: &json::Accessor, matrices: bool) -> Result<(Component, usize)> {
    let Checked::Valid(component) = accessor.component_type else {
        return Err(Fault::invalid("componentType is none that glTF knows"));
    };
    let Checked::Valid(kind) = accessor.type_ else {
        return Err(Fault::invalid("type is none that glTF knows"));
    };
    let components = match kind {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 => 4,
        // Its columns have no padding, whatever the component.
        Type::Mat4 if matrices => 16,
        Type::Mat2 | Type::Mat3 | Type::Mat4 => return Err(Fault::invalid("holds matrices where vectors are needed")),
    };
    Ok((to_component(component.0), components))
}

fn to_component(kind: ComponentType) -> Component {
    match kind {
        ComponentType::I8 => Component::I8,
        ComponentType::U8 => Component::U8,
        ComponentType::I16 => Component::I16,
        ComponentType::U16 => Component::U16,
        ComponentType::U32 => Component::U32,
        ComponentType::F32 => Component::F32,
    }
}

/// Elements of `size` bytes in a view, after checking that all `count` of them are there.
fn packed<'a>(
    buffers: &'a Buffers<'_>,
    view: usize,
    offset: u64,
    count: u64,
    size: usize,
    component: Component,
) -> Result<Packed<'a>> {
    let source = buffers.view(view)?;
    let stride = source.stride.unwrap_or(size);
    if count == 0 {
        return Ok(Packed { bytes: &[], stride, component });
    }
    if stride < size {
        return Err(Fault::invalid(format!(
            "elements of {size} bytes overlap at bufferView {view}'s byteStride {stride}"
        )));
    }
    let end = (count - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64));
    let end = end.and_then(|n| n.checked_add(offset));
    if end.is_none_or(|end| end > source.bytes.len() as u64) {
        return Err(Fault::invalid(format!(
            "{count} elements of {size} bytes every {stride} from byte {offset} do not fit in bufferView {view}, which \
             has {} bytes",
            source.bytes.len()
        )));
    }
    Ok(Packed { bytes: &source.bytes[offset as usize..], stride, component })
}

/// An accessor without a view: all zeros, but for what is sparse.
fn zeros<'a>(count: u64, buffers: &Buffers<'_>, component: Component) -> Result<Packed<'a>> {
    if count > LARGEST_ZERO_FILL.max(buffers.fetched_bytes()) {
        return Err(Fault::new(
            Kind::TooLarge,
            format!("claims {count} elements and has no bufferView that holds them"),
        ));
    }
    Ok(Packed { bytes: &[], stride: 0, component })
}

fn open_sparse<'a>(
    sparse: &sparse::Sparse,
    buffers: &'a Buffers<'_>,
    base_count: u64,
    size: usize,
    component: Component,
) -> Result<Sparse<'a>> {
    let count = sparse.count.0;
    if count > base_count {
        return Err(Fault::invalid(format!("{count} elements deviate of {base_count}")));
    }
    let Checked::Valid(index_type) = sparse.indices.component_type else {
        return Err(Fault::invalid("componentType of the indices is none that glTF knows"));
    };
    let index_type = to_component(index_type.0);
    let (i, v) = (&sparse.indices, &sparse.values);
    let indices = packed(buffers, i.buffer_view.value(), i.byte_offset.0, count, index_type.size(), index_type)?;
    let values = packed(buffers, v.buffer_view.value(), v.byte_offset.0, count, size, component)?;
    let sparse = Sparse { count: count as usize, indices, values };
    let mut previous = None;
    for place in 0..sparse.count {
        let index = sparse.index(place);
        if u64::from(index) >= base_count || previous.is_some_and(|p| index <= p) {
            return Err(Fault::invalid(format!("index {index} at {place} is out of range or does not rise")));
        }
        previous = Some(index);
    }
    Ok(sparse)
}
