//! Small random scenes: a place with things in it, what lies around it, and what lights it.

use super::random::Random;
use crate::common::build::{Facing, diffuse, emitter};
use crate::common::{Builder, look};
use glam::{DVec3, Mat3, Vec3, Vec4, vec3};
use hemicube::scene::{Background, Camera, EnvironmentMap, Light, Material, Scene, TextureRef};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// A scene, a camera that looks at it, and what it holds, in words.
pub struct Case {
    pub scene: Scene,
    pub camera: Camera,
    pub holds: String,
}

/// A scene in the making. The place is 4 wide and 3 high, its floor at 0.
struct Making {
    random: Random,
    builder: Builder,
    holds: Vec<String>,
    /// Outside of it is a closed room: only lamps within it light it.
    is_open: bool,
}

const LOW: Vec3 = vec3(-2.0, 0.0, -2.0);
const HIGH: Vec3 = vec3(2.0, 3.0, 2.0);

/// The scene of a seed.
pub fn case(seed: u64) -> Case {
    let mut making = Making { random: Random(seed), builder: Builder::default(), holds: Vec::new(), is_open: true };
    making.add_place();
    making.add_things();
    if making.is_open {
        making.add_surroundings();
    }
    for _ in 0..1 + making.random.below(2) {
        making.add_light();
    }
    making.finish()
}

impl Making {
    fn says(&mut self, what: impl Into<String>) {
        self.holds.push(what.into());
    }

    fn grey(&mut self) -> usize {
        let albedo = self.random.between(0.1, 0.8);
        self.builder.material(diffuse(albedo))
    }

    fn add_place(&mut self) {
        let grey = self.grey();
        match self.random.below(4) {
            0 => {
                self.says("closed room");
                self.is_open = false;
                self.builder.cuboid(grey, LOW, HIGH, Facing::In);
            }
            1 => {
                self.says("room with an open side");
                let b = &mut self.builder;
                b.floor(grey, 0.0, 2.0);
                b.ceiling(grey, 3.0, 2.0);
                b.quad(grey, vec3(-2.0, 0.0, -2.0), Vec3::X * 4.0, Vec3::Y * 3.0);
                b.quad(grey, vec3(-2.0, 0.0, 2.0), Vec3::NEG_Z * 4.0, Vec3::Y * 3.0);
                b.quad(grey, vec3(2.0, 0.0, -2.0), Vec3::Z * 4.0, Vec3::Y * 3.0);
            }
            2 => {
                self.says("floor and wall");
                self.builder.floor(grey, 0.0, 2.0);
                self.builder.quad(grey, vec3(-2.0, 0.0, -2.0), Vec3::X * 4.0, Vec3::Y * 3.0);
            }
            _ => {
                self.says("floor");
                self.builder.floor(grey, 0.0, 2.0);
            }
        }
    }

    fn add_things(&mut self) {
        for _ in 0..1 + self.random.below(3) {
            let size = self.random.between(0.2, 0.8);
            let place = self.random.point(LOW + size, HIGH - 1.5 * size);
            let grey = self.grey();
            match self.random.below(5) {
                0 => self.builder.sphere(grey, place, size * 0.5, 12, Facing::Out),
                1 => self.add_leaves(place, size),
                2 => self.add_screen(place, size),
                _ => self.builder.cuboid(grey, place - size * 0.5, place + size * 0.5, Facing::Out),
            }
        }
    }

    /// Many small triangles in a ball.
    fn add_leaves(&mut self, place: Vec3, size: f32) {
        let (grey, count) = (self.grey(), self.random.power_of_ten(1.0, 3.0) as u32);
        self.says(format!("{count} leaves"));
        for _ in 0..count {
            let leaf = size * 2.0 / (count as f32).sqrt();
            let [middle, u, v] = [0; 3].map(|_| self.random.point(Vec3::splat(-0.5), Vec3::splat(0.5)));
            let middle = place + size * middle;
            self.builder.triangle(grey, [middle, middle + leaf * u, middle + leaf * v]);
        }
    }

    /// A square with an alpha mask.
    fn add_screen(&mut self, place: Vec3, size: f32) {
        self.says("screen with a mask");
        let texture = Some(self.texture(|lit| if lit { [200, 180, 160, 255] } else { [255, 255, 255, 0] }));
        let cut = Material { base_texture: texture, alpha_cutoff: Some(0.5), ..diffuse(0.8) };
        let material = self.builder.material(cut);
        self.builder.quad(material, place, Vec3::X * size, vec3(0.0, 0.8, 0.6) * size);
    }

    /// A texture of few texels, each of one kind or the other.
    fn texture(&mut self, texel: impl Fn(bool) -> [u8; 4]) -> TextureRef {
        let (width, height) = (1 << self.random.below(7), 1 << self.random.below(6));
        let share = self.random.power_of_ten(-2.0, -0.1);
        let mut texels: Vec<_> = (0..width * height).map(|_| texel(self.random.chance(share))).collect();
        let one = self.random.below(width * height);
        texels[one as usize] = texel(true);
        let texture = self.builder.texture(width, height, texels, true);
        TextureRef { texture, set: 0, transform: Mat3::IDENTITY }
    }

    fn add_surroundings(&mut self) {
        let grey = self.grey();
        if self.random.chance(0.5) {
            let (half, below) = (self.random.power_of_ten(0.7, 6.0), self.random.power_of_ten(-3.0, 0.0));
            self.says(format!("ground of {half:.0}"));
            self.builder.floor(grey, -below, half);
        }
        if self.random.chance(0.15) {
            let far = self.random.power_of_ten(1.0, 6.0);
            self.says(format!("stray triangle {far:.0} away"));
            let place = far * self.random.point(Vec3::NEG_ONE, Vec3::ONE).normalize();
            self.builder.triangle(grey, [place, place + Vec3::X, place + Vec3::Y]);
        }
    }

    fn add_light(&mut self) {
        let colour = self.random.point(Vec3::splat(0.3), Vec3::ONE);
        match self.random.below(if self.is_open { 10 } else { 7 }) {
            0 => self.add_point(colour),
            1 => self.add_spot(colour),
            2 | 3 => self.add_lamp(colour),
            4 => self.add_picture(colour),
            5 => self.add_sign(colour),
            6 => self.add_many(colour),
            7 => self.add_sun(colour),
            8 => self.add_sky(colour),
            _ => self.add_dome(colour),
        }
    }

    /// A place for a light: within a closed room, else sometimes far above.
    fn lamp_place(&mut self, distances: [f32; 2]) -> (Vec3, f32) {
        if !self.is_open || self.random.chance(0.5) {
            return (self.random.point(vec3(-1.5, 2.2, -1.5), vec3(1.5, 2.9, 1.5)), 2.0);
        }
        let far = self.random.power_of_ten(distances[0], distances[1]);
        (vec3(0.0, 1.0, 0.0) - far * self.random.downwards(0.3), far)
    }

    fn add_point(&mut self, colour: Vec3) {
        let (position, far) = self.lamp_place([0.6, 6.0]);
        self.says(format!("point light {far:.0} away"));
        self.builder.light(Light::Point { position, intensity: colour * far * far });
    }

    fn add_spot(&mut self, colour: Vec3) {
        let (position, far) = self.lamp_place([0.6, 3.0]);
        let target = self.random.point(vec3(-1.5, 0.0, -1.5), vec3(1.5, 0.0, 1.5));
        // Wide enough that some pixels show its light.
        let outer = (self.random.power_of_ten(-1.0, 0.3) * 2.0 / far).min(FRAC_PI_2);
        let inner = outer * self.random.below(3) as f32 * 0.5;
        self.says(format!("spot of {outer:.4} rad, {far:.0} away"));
        self.builder.light(Light::Spot {
            position,
            direction: (target - position).normalize(),
            intensity: colour * far * far,
            cos_inner: f64::from(inner).cos(),
            cos_outer: f64::from(outer).cos(),
        });
    }

    fn add_sun(&mut self, colour: Vec3) {
        self.says("sun");
        let direction = self.random.downwards(0.2);
        self.builder.light(Light::Directional { direction, irradiance: colour * 3.0 });
    }

    /// A square that faces the floor, of any size and distance.
    fn add_lamp(&mut self, colour: Vec3) {
        let (position, far) = self.lamp_place([0.6, 4.0]);
        let size = far * self.random.power_of_ten(-2.5, -0.3);
        self.says(format!("lamp of {size:.3}, {far:.0} away"));
        let lamp = emitter(colour * (far / size).powi(2));
        let material = self.builder.material(Material { double_sided: self.random.chance(0.3), ..lamp });
        self.add_square(material, position, size);
    }

    /// A square under the ceiling that faces the floor.
    fn add_hanging(&mut self, material: usize, size: f32) {
        let middle = self.random.point(vec3(-0.9, 2.2, -0.9), vec3(0.9, 2.4, 0.9));
        self.add_square(material, middle, size);
    }

    fn add_square(&mut self, material: usize, middle: Vec3, size: f32) {
        let down = (vec3(0.0, 0.5, 0.0) - middle).normalize();
        let u = down.any_orthonormal_vector() * size;
        let v = down.cross(u);
        self.builder.quad(material, middle - 0.5 * (u + v), u, v);
    }

    /// An emissive square with a texture.
    fn add_picture(&mut self, colour: Vec3) {
        self.says("emissive texture");
        let texture = self.texture(|lit| if lit { [255, 255, 255, 255] } else { [0, 0, 0, 255] });
        let size = self.random.between(0.2, 1.0);
        let lamp = Material { emission_texture: Some(texture), ..emitter(colour * 30.0 / (size * size)) };
        let material = self.builder.material(lamp);
        self.add_hanging(material, size);
    }

    /// An emissive square with an alpha mask.
    fn add_sign(&mut self, colour: Vec3) {
        self.says("emissive mask");
        let texture = self.texture(|lit| if lit { [255, 255, 255, 255] } else { [255, 255, 255, 0] });
        let size = self.random.between(0.2, 1.0);
        let sign = Material {
            base_texture: Some(texture),
            base_color: Vec4::new(0.0, 0.0, 0.0, 1.0),
            alpha_cutoff: Some(0.5),
            ..emitter(colour * 30.0 / (size * size))
        };
        let material = self.builder.material(sign);
        self.add_hanging(material, size);
    }

    /// Many small emissive triangles.
    fn add_many(&mut self, colour: Vec3) {
        let count = self.random.power_of_ten(1.0, 4.3) as u32;
        self.says(format!("{count} emissive triangles"));
        let material = self.builder.material(emitter(colour * self.random.power_of_ten(1.0, 2.0)));
        let size = 1.0 / (count as f32).sqrt();
        for _ in 0..count {
            let middle = self.random.point(vec3(-1.5, 2.3, -1.5), vec3(1.5, 2.8, 1.5));
            let [u, v] = [0; 2].map(|_| self.random.point(Vec3::splat(-0.5), Vec3::splat(0.5)));
            self.builder.triangle(material, [middle, middle + size * u, middle + size * v]);
        }
    }

    fn add_dome(&mut self, colour: Vec3) {
        let (radius, n) = (self.random.power_of_ten(1.0, 5.0), 4 << self.random.below(4));
        self.says(format!("emissive dome of {radius:.0}, {n} rows"));
        let material = self.builder.material(emitter(colour));
        self.builder.sphere(material, Vec3::ZERO, radius, n, Facing::In);
    }

    /// A constant sky, or a map of any size with bright texels of any strength.
    fn add_sky(&mut self, colour: Vec3) {
        if self.random.chance(0.3) {
            self.says("constant sky");
            return self.builder.background(Background::Constant(colour));
        }
        let (width, height) = (1 << self.random.below(9), 1 << self.random.below(8));
        let mut rgb = vec![(colour * 0.3).to_array(); (width * height) as usize];
        for (i, texel) in rgb.iter_mut().enumerate() {
            let across = (i as u32 % width) as f32 / width as f32 * TAU;
            *texel = (Vec3::from(*texel) * (1.2 + across.sin())).to_array();
        }
        let suns = self.random.below(3);
        for _ in 0..suns {
            let (row, column) = (self.random.below(height.div_ceil(2)), self.random.below(width));
            let solid_angle = TAU / width as f32 * PI / height as f32 * ((row as f32 + 0.5) * PI / height as f32).sin();
            rgb[(row * width + column) as usize] = (colour * self.random.between(0.5, 4.0) / solid_angle).to_array();
        }
        self.says(format!("sky of {width} × {height}, {suns} suns"));
        self.builder.background(Background::Map(EnvironmentMap { width, height, rgb }));
    }

    /// The scene at any scale.
    fn finish(mut self) -> Case {
        let scale = if self.random.chance(0.5) { 1.0 } else { self.random.power_of_ten(-4.0, 4.0) };
        self.says(format!("scale {scale:.0e}"));
        let eye = self.random.point(vec3(-1.6, 0.8, 1.2), vec3(1.6, 2.4, 1.9));
        let target = self.random.point(vec3(-0.6, 0.2, -1.0), vec3(0.6, 0.8, 0.0));
        let [eye, target]: [DVec3; 2] = [eye, target].map(|p| (p * scale).into());
        let camera = look(eye, target, 70.0);
        let mut scene = self.builder.build();
        scene.positions.iter_mut().for_each(|p| *p *= scale);
        for light in &mut scene.lights {
            match light {
                Light::Point { position, intensity } | Light::Spot { position, intensity, .. } => {
                    (*position, *intensity) = (*position * scale, *intensity * scale * scale);
                }
                Light::Directional { .. } => {}
            }
        }
        Case { scene, camera, holds: self.holds.join(", ") }
    }
}
