//! `hemicube render --show-probes`: the samples of a volume over the picture.

use hemicube::image::Picture;
use hemicube::reference::balls::{self, Ball};
use hemicube::reference::{Tracer, View};
use hemicube::scene::{Camera, Scene};
use hemicube::volume::{State, Volume};

/// Radius of a ball, in shortest sides of its smallest cell.
const RADIUS: f64 = 0.12;

/// Draws the samples of `volume` over `picture`, which shows the scene through `camera`.
pub fn draw(picture: &mut Picture, scene: &Scene, camera: &Camera, volume: &Volume) {
    let view = View::new(camera, picture.width, picture.height);
    let ball = |(sample, size): (&hemicube::volume::Sample, f64)| Ball {
        centre: sample.position - scene.origin,
        radius: RADIUS * size,
        light: (sample.state != State::Inside).then(|| sample.coefficients.iter().map(|c| c.as_dvec3()).collect()),
    };
    let balls: Vec<Ball> = volume.samples.iter().zip(smallest_cells(volume)).map(ball).collect();
    balls::draw(picture, &Tracer::new(scene), &view, &balls);
}

/// Of each sample the shortest side of the smallest cell at it.
fn smallest_cells(volume: &Volume) -> Vec<f64> {
    let mut sizes = vec![f64::INFINITY; volume.samples.len()];
    for leaf in &volume.lattice.leaves {
        let size = volume.lattice.size(leaf.level).min_element();
        for sample in leaf.corners {
            sizes[sample as usize] = size.min(sizes[sample as usize]);
        }
    }
    sizes
}
