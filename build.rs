//! Compiles every shader under `glsl/<pass>/` to SPIR-V with shaderc, so that the shipped binary needs no compiler.
//!
//! `glsl/inc` and `glsl/shared` hold included text only. For each shader `OUT_DIR` gets `<pass>.<file>.spv` and
//! `<pass>.<file>.rs`, a `vk::shader::Shader` with the bindings, push constants and specialisation constants that its text
//! declares, read by `vk::shader::spirv!`.
//!
//! A shader with a line `// Variants: A B` is compiled once for each subset of these names, each of them a `#define`: what is left
//! out has then no binding. They make an array in `<pass>.<file>.rs`, read by `vk::shader::variants!`.

#[path = "build/reflect.rs"]
mod reflect;

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR")).join("glsl");
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo::rerun-if-changed=glsl");
    println!("cargo::rerun-if-changed=build");

    let compiler = shaderc::Compiler::new().expect("shaderc starts (packages: see tools/setup.sh)");
    for pass in subfolders(&root) {
        let name = pass.file_name().expect("a folder has a name").to_string_lossy().into_owned();
        if name == "inc" || name == "shared" {
            continue;
        }
        for shader in files(&pass) {
            let kind = match shader.extension().and_then(|e| e.to_str()) {
                Some("vert") => shaderc::ShaderKind::Vertex,
                Some("frag") => shaderc::ShaderKind::Fragment,
                Some("comp") => shaderc::ShaderKind::Compute,
                _ => continue,
            };
            let file = shader.file_name().expect("a file has a name").to_string_lossy().into_owned();
            let source = fs::read_to_string(&shader).expect("shader is readable");
            let one = |defines: &[&str], suffix: &str| {
                let compiled = compile(&compiler, &root, (&shader, &source), kind, defines, true);
                let name = format!("{name}.{file}{suffix}");
                fs::write(out.join(format!("{name}.spv")), compiled).expect("OUT_DIR is writable");
                // Optimisation drops what is not used: the text's declarations are those of the plain translation.
                let plain = compile(&compiler, &root, (&shader, &source), kind, defines, false);
                reflect::shader(&name, &plain)
            };
            let text = match variants_of(&source) {
                None => format!("&{}", one(&[], "")),
                Some(names) => reflect::variants(&names, |chosen, index| one(chosen, &format!(".{index}"))),
            };
            fs::write(out.join(format!("{name}.{file}.rs")), text).expect("OUT_DIR is writable");
        }
    }
    println!("cargo::rustc-env=HEMICUBE_SHADERS={:016x}", digest(&out));
}

/// A number for all compiled shaders together: FNV-1a (Fowler, Noll and Vo 1991).
fn digest(out: &Path) -> u64 {
    let compiled = files(out).into_iter().filter(|path| path.extension().is_some_and(|e| e == "spv"));
    let bytes = compiled.flat_map(|path| fs::read(path).expect("a compiled shader is readable"));
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// The names after `// Variants:`.
fn variants_of(source: &str) -> Option<Vec<&str>> {
    source.lines().find_map(|line| line.strip_prefix("// Variants:")).map(|names| names.split_whitespace().collect())
}

fn compile(
    compiler: &shaderc::Compiler,
    root: &Path,
    (shader, source): (&Path, &str),
    kind: shaderc::ShaderKind,
    defines: &[&str],
    optimised: bool,
) -> Vec<u8> {
    let mut options = shaderc::CompileOptions::new().expect("shaderc makes options");
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(if optimised {
        shaderc::OptimizationLevel::Performance
    } else {
        shaderc::OptimizationLevel::Zero
    });
    defines.iter().for_each(|name| options.add_macro_definition(name, None));
    if optimised {
        options.set_generate_debug_info();
    }
    options.set_warnings_as_errors();
    options.set_include_callback(|requested, _, _, _| {
        let path = root.join(requested);
        let content = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(shaderc::ResolvedInclude { resolved_name: path.display().to_string(), content })
    });
    let name = shader.strip_prefix(root).expect("shader lies under glsl/").display().to_string();
    match compiler.compile_into_spirv(source, kind, &name, "main", Some(&options)) {
        Ok(artifact) => artifact.as_binary_u8().to_vec(),
        Err(error) => panic!("{error}"),
    }
}

// Debian 12's static shaderc leaves glslang and SPIRV-Tools to whoever links it, which is this build script.
#[link(name = "glslang")]
#[link(name = "SPIRV")]
#[link(name = "MachineIndependent")]
#[link(name = "GenericCodeGen")]
#[link(name = "OGLCompiler")]
#[link(name = "OSDependent")]
#[link(name = "SPIRV-Tools-opt")]
#[link(name = "SPIRV-Tools")]
unsafe extern "C" {}

fn subfolders(root: &Path) -> Vec<PathBuf> {
    sorted(root).into_iter().filter(|p| p.is_dir()).collect()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    sorted(folder).into_iter().filter(|p| p.is_file()).collect()
}

fn sorted(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<_> =
        fs::read_dir(folder).expect("glsl/ is readable").map(|e| e.expect("entry is readable").path()).collect();
    paths.sort();
    paths
}
