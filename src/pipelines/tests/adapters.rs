//! On graphics adapters the methods show what they show on the processor.

use super::{image_by, relative_difference, scenes, values};
use crate::film::measure::{differing, epsilon, relative_mse};
use crate::gpu::device::Gpu;
use crate::pipelines::OpenDevice;
use crate::pipelines::frame::Frame;
use crate::pipelines::on_gpu::{Method as _, Shown};
use crate::pipelines::resources::{EnvironmentBuffers, WorldBuffers};
use crate::pipelines::stochastic_rasterization::compute::Rasterizer;
use crate::scene::environment::Environment as Surroundings;
use crate::scene::world::World;
use shutterlab_stimuli::Stimulus;
use shutterlab_stimuli::scene::{BuiltIn, Coat, Environment, Material, Object, Shape};
use shutterlab_stimuli::stimulus::{Method, ShutterProfile};
use std::rc::Rc;

/// Spheres and planes beside the model of `first`, a smooth coat and a trapezoid of light, in a sky.
fn mixed(first: &Stimulus) -> Stimulus {
    let mut mixed = first.clone();
    let ball = &mut mixed.scene.objects[0];
    ball.material = Some(Material::Checker {
        cells: 6,
        light: 0.8,
        dark: 0.1,
        coat: Some(Coat::Dielectric { roughness: 0.3, ior: 1.5 }),
    });
    let sphere = Object {
        name: "sphere".into(),
        shape: Shape::Sphere { radius_m: 0.3 },
        position_m: [-0.6, 0.3, 0.4],
        ..ball.clone()
    };
    let plane = Object {
        name: "plane".into(),
        shape: Shape::Plane { side_m: 20.0 },
        position_m: [0.0, -0.7, 0.0],
        motion: None,
        ..ball.clone()
    };
    mixed.scene.objects.extend([sphere, plane]);
    mixed.scene.environment = Environment::BuiltIn(BuiltIn::ClearSky);
    mixed.shutter_profile = ShutterProfile::Trapezoid { ramp_fraction: 0.3 };
    mixed
}

/// A graphics adapter, if there is one. With `SHUTTERLAB_REQUIRE_GPU` set, not finding one is a failure.
fn adapter() -> Option<Rc<Gpu>> {
    let gpu = Gpu::open();
    if let Err(error) = &gpu {
        assert!(std::env::var_os("SHUTTERLAB_REQUIRE_GPU").is_none(), "{error}");
    }
    gpu.ok().map(Into::into)
}

/// On a graphics adapter all is as on the processor.
#[test]
fn adapters_show_what_the_processor_shows() {
    let Some(gpu) = adapter() else { return };
    let assets = tempfile::tempdir().unwrap();
    let mut all = scenes(assets.path());
    all.push(("mixed", mixed(&all[0].1)));
    for (_, method) in Method::ALL {
        let mut pipelines = [OpenDevice::Cpu, OpenDevice::Gpu(gpu.clone())]
            .map(|device| device.pipeline(method, assets.path()));
        for (name, stimulus) in &all {
            let stimulus = Stimulus { method, samples: 48, ..stimulus.clone() };
            let [on_cpu, on_gpu] =
                pipelines.each_mut().map(|pipeline| image_by(&mut **pipeline, &stimulus));
            if method == Method::AccumulationBuffer {
                // Adapters snap corners to grids of their own, mostly of 2⁻⁸ pixels: edges are a little elsewhere, and a
                // needle of a third of a pixel is mostly edge.
                let most = if *name == "thin" { 0.06 } else { 0.005 };
                let error = relative_difference(&on_gpu, &on_cpu);
                assert!(error < most, "{name}, {method}: {error}");
                continue;
            }
            let error = relative_mse(&on_gpu, &on_cpu, epsilon(&on_cpu, &on_cpu)).sqrt();
            assert!(error <= 1e-3, "{name}, {method}: {error}");
            let differing = differing(&on_gpu, &on_cpu, 1.0 / 255.0);
            assert!(differing <= 1e-3, "{name}, {method}: {differing}");
        }
    }
}

/// However few triangles are put into tiles together and however many samples are drawn before, on an adapter the image is
/// the same.
#[test]
fn bands_and_earlier_films_change_nothing() {
    let Some(gpu) = adapter() else { return };
    let assets = tempfile::tempdir().unwrap();
    let stimulus = mixed(&scenes(assets.path())[0].1);
    let view = stimulus.views(60).remove(0);
    let world = &World::load(&stimulus, assets.path()).unwrap();
    let frame = &Frame::new(&stimulus, world, &view, 60);
    let sky = Surroundings::load(&stimulus.scene.environment, assets.path()).unwrap();
    let environment = &EnvironmentBuffers::new(&gpu, &sky).unwrap();
    let world_buffers = &WorldBuffers::new(&gpu, world).unwrap();
    let shown = Shown { gpu: &gpu, frame, world, world_buffers, environment };
    let film = |most_entries: u64, samples: &[u32]| {
        let mut rasterizer = Rasterizer::new(most_entries);
        rasterizer.films(&shown, &view, samples).unwrap().pop().unwrap()
    };
    let at_once = film(u64::MAX, &[20]);
    assert!(values(&at_once.image()).sum::<f64>() > 10.0);
    assert_eq!(film(1, &[20]), at_once);
    assert_eq!(film(u64::MAX, &[3, 19, 20]), at_once);
}
