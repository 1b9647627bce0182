//! Global illumination by rasterisation alone, on raw Vulkan: irradiance-cache splatting.
//!
//! # A frame
//!
//! Data goes one way: file → [`scene`] → needs → [`renderer::Plan`] → geometry on the device → G-buffer → direct light on
//! the surfaces → records ⇄ captures → sums → [`image`] → [`report`].
//!
//! # What lives how long
//!
//! Nothing depends on what lives shorter than itself.
//!
//! | what | where | made by |
//! |---|---|---|
//! | device: queue, memory, pipelines | [`vk::Device`] | the user, once |
//! | scene on the device: geometry, tree, textures, cells, light samples | [`renderer::Renderer`] | [`renderer::Renderer::open`]; the file and the settings of the scene |
//! | lit surface: radiance of both sides of every cell | [`passes::geometry::Geometry::cell_radiance`] | the first view |
//! | records: irradiance at places, with gradients | [`methods::records`] | views, each what it lacks; or a file |
//! | view: G-buffer, sums of splats, layers of the image | [`renderer::Renderer::render`] | a camera and [`renderer::ViewSettings`] |
//!
//! | room | what is in it | imports |
//! |---|---|---|
//! | [`math`] | pure functions: measures, gradients, sequences; CPU twins of the shaders | nothing |
//! | [`image`] | layered float pictures, EXR and PNG, tone mapping, error metrics | nothing |
//! | [`scene`] | glTF in; meshes, materials, lights, cameras, background | `math` |
//! | [`mod@reference`] | the truth on the CPU: path tracer, Ward's octree cache | `scene`, `math`, `image` |
//! | [`volume`] | irradiance volumes: placement of samples, interpolation, files, engines' formats | `math`, `image` |
//! | [`vk`] | Vulkan made plain; every `unsafe` of the renderer | nothing |
//! | [`passes`] | one file a GPU pass, its shaders in `glsl/<same name>/` | `vk`, `scene`, `math` |
//! | [`methods`] | techniques: passes composed | `passes`, `volume` |
//! | [`bake`] | light at vertices, scenes written as GLB | `methods`, `scene` |
//! | [`renderer`] | the plan, a scene that stays on the device, views of it | `methods` |
//! | [`report`] | profile, statistics, trace, progress | `image` |
//! | [`guide`] | how a frame is computed, limits, measurements with their commands | nothing |
//!
//! # Use
//!
//! ```
//! use hemicube::{renderer, scene, vk};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = scene::cornell(); // or scene::load(path)?
//! let (camera, _) = scene.camera(None)?;
//! let device = vk::Device::new(vk::Instance::new(false)?, &vk::DeviceChoice::Best)?;
//! let settings = renderer::Settings { width: 64, height: 64, ..Default::default() };
//! let frame = renderer::render(&device, &scene, &camera, &settings, &mut |_stage, _done, _all| {})?;
//! let [red, _green, _blue] = frame.picture.rgb("").expect("a picture has its colour");
//! assert!(frame.cache.records > 0 && red.iter().any(|r| *r > 0.0));
//! for pass in &frame.passes {
//!     println!("{}: {:?}", pass.name, pass.gpu);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Several views of one scene: [`renderer::Renderer`], and `examples/two_views.rs`.
//!
//! Units are glTF's, taken as radiometric RGB: radiance in W·sr⁻¹·m⁻², irradiance in W·m⁻², lengths in scene units.

// What a library prints may go unread: what it has to say it returns.
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod bake;
pub mod guide;
pub mod image;
pub mod math;
pub mod methods;
pub mod passes;
pub mod reference;
pub mod renderer;
pub mod report;
pub mod scene;
pub mod vk;
pub mod volume;
