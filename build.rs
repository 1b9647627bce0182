//! Compiles every shader under `glsl/<pass>/` to SPIR-V with shaderc, so that the shipped binary needs no compiler.
//!
//! `glsl/inc` and `glsl/shared` hold included text only. The output name is `<pass>.<stage>.spv` in `OUT_DIR`, read by
//! `vk::shader::spirv!`.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR")).join("glsl");
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets OUT_DIR"));
    println!("cargo::rerun-if-changed=glsl");

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
            let spirv = compile(&compiler, &root, &shader, kind);
            fs::write(out.join(format!("{name}.{file}.spv")), spirv).expect("OUT_DIR is writable");
        }
    }
}

fn compile(compiler: &shaderc::Compiler, root: &Path, shader: &Path, kind: shaderc::ShaderKind) -> Vec<u8> {
    let source = fs::read_to_string(shader).expect("shader is readable");
    let mut options = shaderc::CompileOptions::new().expect("shaderc makes options");
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_2 as u32);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(|requested, _, _, _| {
        let path = root.join(requested);
        let content = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(shaderc::ResolvedInclude { resolved_name: path.display().to_string(), content })
    });
    let name = shader.strip_prefix(root).expect("shader lies under glsl/").display().to_string();
    match compiler.compile_into_spirv(&source, kind, &name, "main", Some(&options)) {
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
