//! What a shader's text declares, as the Rust text of a `vk::shader::Shader`.

use rspirv::dr::{Instruction, Module, Operand};
use rspirv::spirv::{Decoration, Op, StorageClass};
use std::collections::HashMap;
use std::fmt::Write;

/// A `Shader` for the SPIR-V `code`, whose optimised form lies beside the including file as `<name>.spv`.
pub fn shader(name: &str, code: &[u8]) -> String {
    let module = rspirv::dr::load_bytes(code).unwrap_or_else(|error| panic!("{name}: {error}"));
    let about = About::new(&module);
    let mut text = format!(
        "crate::vk::shader::Shader {{ name: {name:?}, spirv: include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{name}.spv\")), \
         bindings: &["
    );
    for (set, binding, name, kind) in about.bindings() {
        let _ = write!(
            text,
            "crate::vk::shader::Slot {{ set: {set}, binding: {binding}, name: {name:?}, kind: ash::vk::DescriptorType::{kind} }}, "
        );
    }
    let _ = write!(text, "], push_bytes: {}, constants: &[", about.push_bytes());
    about.constants().iter().for_each(|(id, name)| {
        let _ = write!(text, "({name:?}, {id}), ");
    });
    text + "] }"
}

/// A `Variants` with a shader for each subset of `names`, the subset's bits being its index.
pub fn variants(names: &[&str], shader: impl Fn(&[&str], usize) -> String) -> String {
    let subset =
        |bits: usize| names.iter().enumerate().filter(move |(i, _)| (bits >> i) & 1 == 1).map(|(_, name)| *name);
    let all: Vec<_> = (0..1 << names.len()).map(|bits| shader(&subset(bits).collect::<Vec<_>>(), bits)).collect();
    format!("&crate::vk::shader::Variants {{ names: &{names:?}, shaders: &[{}] }}", all.join(", "))
}

/// A module with its instructions by result.
struct About<'a> {
    module: &'a Module,
    by_result: HashMap<u32, &'a Instruction>,
    names: HashMap<u32, &'a str>,
}

impl<'a> About<'a> {
    fn new(module: &'a Module) -> Self {
        let by_result = module.types_global_values.iter().filter_map(|i| Some((i.result_id?, i))).collect();
        let name = |i: &'a Instruction| match (i.class.opcode, i.operands.as_slice()) {
            (Op::Name, [Operand::IdRef(id), Operand::LiteralString(name)]) => Some((*id, name.as_str())),
            _ => None,
        };
        Self { module, by_result, names: module.debug_names.iter().filter_map(name).collect() }
    }

    /// Set, binding, name and kind of each resource, in order.
    fn bindings(&self) -> Vec<(u32, u32, String, &'static str)> {
        let mut all: Vec<_> = self
            .variables()
            .filter_map(|(id, kind, class)| {
                let (set, binding) =
                    (self.decoration(id, Decoration::DescriptorSet)?, self.decoration(id, Decoration::Binding)?);
                Some((set, binding, self.name(id, kind), self.kind(kind, class)))
            })
            .collect();
        all.sort();
        all
    }

    /// Bytes of the push constant block; 0 without one.
    fn push_bytes(&self) -> u32 {
        let block = self.variables().find(|(_, _, class)| *class == StorageClass::PushConstant);
        block.map_or(0, |(_, kind, _)| self.size(kind, None))
    }

    /// Number and name of each specialisation constant.
    fn constants(&self) -> Vec<(u32, String)> {
        let ids = self.by_result.keys();
        let constant = |id: &u32| Some((self.decoration(*id, Decoration::SpecId)?, self.names.get(id)?.to_string()));
        let mut all: Vec<_> = ids.filter_map(constant).collect();
        all.sort();
        all
    }

    /// Number, type and storage class of each global variable.
    fn variables(&self) -> impl Iterator<Item = (u32, u32, StorageClass)> + '_ {
        self.module.types_global_values.iter().filter(|i| i.class.opcode == Op::Variable).filter_map(|i| {
            let pointer = self.by_result.get(&i.result_type?)?;
            match pointer.operands.as_slice() {
                [Operand::StorageClass(class), Operand::IdRef(kind)] => Some((i.result_id?, *kind, *class)),
                _ => None,
            }
        })
    }

    /// A variable's own name, or that of its block.
    fn name(&self, id: u32, kind: u32) -> String {
        let named = |id| self.names.get(&id).copied().filter(|name| !name.is_empty());
        named(id).or_else(|| named(kind)).unwrap_or_default().to_owned()
    }

    fn kind(&self, kind: u32, class: StorageClass) -> &'static str {
        let kind = self.by_result[&kind];
        match (class, kind.class.opcode) {
            (StorageClass::StorageBuffer, _) => "STORAGE_BUFFER",
            (_, Op::TypeSampledImage) => "COMBINED_IMAGE_SAMPLER",
            (_, Op::TypeImage) => match kind.operands.as_slice() {
                [_, Operand::Dim(rspirv::spirv::Dim::DimBuffer), ..] => "UNIFORM_TEXEL_BUFFER",
                [_, _, _, _, _, Operand::LiteralBit32(2), ..] => "STORAGE_IMAGE",
                _ => "SAMPLED_IMAGE",
            },
            (class, op) => panic!("a resource of a kind that is not known here: {class:?} {op:?}"),
        }
    }

    /// Bytes of a type whose members have explicit offsets. `stride`: of a matrix's columns.
    fn size(&self, kind: u32, stride: Option<u32>) -> u32 {
        let of = self.by_result[&kind];
        let number = |i: usize| match of.operands[i] {
            Operand::LiteralBit32(n) => n,
            Operand::IdRef(n) => n,
            ref other => panic!("{other:?} in a type"),
        };
        match of.class.opcode {
            Op::TypeInt | Op::TypeFloat => number(0) / 8,
            Op::TypeVector => number(1) * self.size(number(0), None),
            Op::TypeMatrix => number(1) * stride.unwrap_or_else(|| self.size(number(0), None)),
            Op::TypeArray => {
                let count = match self.by_result[&number(1)].operands[0] {
                    Operand::LiteralBit32(n) => n,
                    ref other => panic!("{other:?} as an array's length"),
                };
                count * self.decoration(kind, Decoration::ArrayStride).unwrap_or_else(|| self.size(number(0), None))
            }
            Op::TypeStruct => {
                let last = of.operands.len() - 1;
                let (offset, stride) =
                    (self.member(kind, last, Decoration::Offset), self.member(kind, last, Decoration::MatrixStride));
                offset.unwrap_or(0) + self.size(number(last), stride)
            }
            op => panic!("{op:?} among push constants"),
        }
    }

    fn decoration(&self, id: u32, wanted: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|i| match i.operands.as_slice() {
            [Operand::IdRef(of), Operand::Decoration(kind), Operand::LiteralBit32(value)]
                if *of == id && *kind == wanted =>
            {
                Some(*value)
            }
            _ => None,
        })
    }

    fn member(&self, id: u32, member: usize, wanted: Decoration) -> Option<u32> {
        self.module.annotations.iter().find_map(|i| match i.operands.as_slice() {
            [
                Operand::IdRef(of),
                Operand::LiteralBit32(at),
                Operand::Decoration(kind),
                Operand::LiteralBit32(value),
            ] if *of == id && *at as usize == member && *kind == wanted => Some(*value),
            _ => None,
        })
    }
}
