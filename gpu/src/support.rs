//! GPU support for the program `cosmic`.

use std::num::NonZeroUsize;
use std::sync::Arc;

use cosmic::case::Case;
use cosmic::error::{Error, Result};
use cosmic::objective::of_scene;
use cosmic::population::{Batch, Populations};
use cosmic::scene::Scene;
use cosmic::simulator::{Simulator, Span, Wanted};
use cosmic_gpu::{Gpu, OnGpu, Population, adapters};
use cosmic_program::GpuSupport;
use serde_json::{Value, json};

/// The adapters of Vulkan, Metal and DirectX 12.
pub(crate) struct Support;

fn usage(error: impl ToString) -> Error {
    Error::Usage(error.to_string())
}

/// The sweeps of an optimisation, with the cotangents that each computes.
const SWEEPS: [(&str, Option<Wanted>); 3] = [
    ("rollouts", None),
    ("gradients of designs", Some(wanted(true))),
    ("gradients of controllers", Some(wanted(false))),
];

const fn wanted(bodies: bool) -> Wanted {
    Wanted {
        bodies,
        controllers: !bodies,
        surroundings: false,
    }
}

impl GpuSupport for Support {
    fn adapters(&self) -> Vec<String> {
        let describe = |adapter: &cosmic_gpu::Adapter| {
            format!(
                "{} ({:?}, {:?}, {})",
                adapter.name, adapter.device_type, adapter.backend, adapter.driver_info
            )
        };
        adapters().iter().map(describe).collect()
    }

    fn open(&self, threads: Option<NonZeroUsize>) -> Result<Arc<dyn Populations>> {
        let gpu = Gpu::of_environment().map_err(usage)?;
        Ok(Arc::new(OnGpu::new(gpu, threads).map_err(usage)?))
    }

    fn explain(&self, case: &Case, scene: &Scene) -> Result<Vec<(&'static str, Value)>> {
        let gpu = Gpu::of_environment().map_err(usage)?;
        let device = OnGpu::new(gpu, None).map_err(usage)?;
        let (gpu, simulator) = (
            device.gpu(),
            Simulator::new(&case.lattice, &case.physics, &case.observation),
        );
        let steps = case.physics.steps;
        let loss = of_scene(scene);
        let limits = gpu.limits();
        let mut facts = vec![
            ("adapter", json!(gpu.adapter().name)),
            ("driver", json!(gpu.adapter().driver_info)),
            (
                "memory of a workgroup, bytes",
                json!(limits.max_compute_workgroup_storage_size),
            ),
            ("largest buffer, MiB", json!(gpu.largest_buffer() >> 20)),
            ("memory for buffers, MiB", json!(gpu.memory() >> 20)),
            ("steps in a dispatch", json!(gpu.steps_at_once())),
            ("invocations of a robot", json!(cosmic_gpu::WORKGROUP)),
        ];
        for (name, by) in SWEEPS {
            let observed = match by {
                None => vec![steps],
                Some(_) => loss.observed(steps),
            };
            let span = Span {
                watched: by.is_none(),
                ..Span::from_start(observed)
            };
            let asked = Batch {
                simulator: simulator.clone(),
                surroundings: vec![simulator.surroundings()],
                bodies: vec![case.body()],
                controllers: vec![case.controller.clone()],
                starts: vec![case.start.clone()],
                span,
            };
            facts.push((name, plan(&device, &asked, by)));
        }
        Ok(facts)
    }
}

/// Describes how a sweep runs, or why it cannot.
fn plan(device: &OnGpu, asked: &Batch, by: Option<Wanted>) -> Value {
    let planned = || -> std::result::Result<String, String> {
        let printed = device.printed(asked, by)?;
        let program = printed.program.clone();
        let reverses = usize::from(by.is_some());
        let spilled = program.spilled();
        let (bytes, barriers) = (program.memory()[reverses], program.barriers()[reverses]);
        let compiled = match by {
            None => Population::only_forward(device.gpu(), program),
            Some(_) => Population::new(device.gpu(), program),
        };
        let compiled = compiled.map_err(|error| error.to_string())?;
        let observed = &asked.span.observed;
        let steps = observed.last().copied().unwrap_or(0);
        let room = compiled.room(steps, observed.len(), by.is_some());
        let spilled = match spilled {
            0 => String::new(),
            numbers => format!(", {} bytes in a buffer, which is slower", 4 * numbers),
        };
        Ok(format!(
            "up to {room} robots at once, {bytes} bytes of a workgroup{spilled}, {barriers} barriers a step"
        ))
    };
    json!(planned().unwrap_or_else(|why| format!("not possible: {why}")))
}
