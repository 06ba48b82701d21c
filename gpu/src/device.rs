//! Finding a device, and the buffers and shaders on it.

use std::error::Error;
use std::fmt::{self, Display};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::sync::{Arc, OnceLock};

use pollster::block_on;
use wgpu::{
    Adapter, Backends, BindGroup, Buffer, BufferDescriptor, BufferUsages, CommandEncoder,
    ComputePipeline, ComputePipelineDescriptor, Device, DeviceDescriptor, DeviceType, Instance,
    InstanceDescriptor, PipelineCompilationOptions, PollType, Queue, ShaderModuleDescriptor,
    ShaderSource,
};

use crate::wgsl::{GROUPS_IN_A_ROW, Printed};

/// A device that runs printed programs. Copies are the same device.
#[derive(Clone)]
pub struct Gpu {
    device: Device,
    queue: Queue,
    adapter: wgpu::AdapterInfo,
    limits: wgpu::Limits,
    /// The first error that the device has reported outside of a call.
    failed: Arc<OnceLock<String>>,
    memory: u64,
    /// The bindings of a printed program.
    groups: wgpu::BindGroupLayout,
}

/// What went wrong on a device.
#[derive(Debug)]
pub enum GpuError {
    /// No adapter fits. The text says what was looked for and what was found.
    NoAdapter(String),
    /// The device could not be opened.
    NotOpened(String),
    /// The program needs more than the device has.
    TooLarge(String),
    /// The driver refused the program. The two texts are its message and the program.
    Refused(String, String),
    /// The device was lost, or a command failed.
    Failed(String),
}

impl Display for GpuError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NoAdapter(why) => write!(f, "there is no GPU to run on: {why}"),
            Self::NotOpened(why) => write!(f, "the GPU could not be opened: {why}"),
            Self::TooLarge(why) => write!(f, "the robot does not fit on the GPU: {why}"),
            Self::Refused(why, _) => write!(f, "the driver of the GPU refused the program: {why}"),
            Self::Failed(why) => write!(f, "the GPU stopped working: {why}"),
        }
    }
}

impl Error for GpuError {}

impl GpuError {
    /// The message. The text of a refused program is written to a file in this folder, which the message then names.
    pub fn told(&self, folder: &Path) -> String {
        let Self::Refused(_, text) = self else {
            return self.to_string();
        };
        let mut hasher = DefaultHasher::new();
        text.hash(&mut hasher);
        let path = folder.join(format!("cosmic-refused-{:016x}.wgsl", hasher.finish()));
        match std::fs::write(&path, text) {
            Ok(()) => format!("{self}; the program is in {}", path.display()),
            Err(error) => format!(
                "{self}; the program cannot be written to {}: {error}",
                path.display()
            ),
        }
    }
}

/// The interfaces that are tried: Vulkan, Metal and DirectX 12.
fn instance() -> Instance {
    Instance::new(InstanceDescriptor {
        backends: Backends::VULKAN | Backends::METAL | Backends::DX12,
        ..InstanceDescriptor::new_without_display_handle()
    })
}

/// The adapters of this machine, the fastest kinds first.
pub fn adapters() -> Vec<wgpu::AdapterInfo> {
    sorted().iter().map(Adapter::get_info).collect()
}

fn sorted() -> Vec<Adapter> {
    let mut adapters = block_on(instance().enumerate_adapters(Backends::all()));
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu | DeviceType::VirtualGpu => 1,
        DeviceType::Other => 2,
        DeviceType::Cpu => 3,
    });
    adapters
}

/// A part of the name of the adapter to take.
const NAME: &str = "COSMIC_GPU";
/// The budget of memory for the buffers of a population, in MiB.
const MEMORY: &str = "COSMIC_GPU_MEMORY";

impl Gpu {
    /// Opens the adapter that the environment names (`COSMIC_GPU`), or the first one, with the budget of memory that the
    /// environment names (`COSMIC_GPU_MEMORY`, in MiB).
    ///
    /// # Errors
    /// If there is no such adapter, it cannot be opened, or the budget is not a whole number, 1 or more.
    pub fn of_environment() -> Result<Self, GpuError> {
        let gpu = Self::open(std::env::var(NAME).ok().as_deref())?;
        let Ok(memory) = std::env::var(MEMORY) else {
            return Ok(gpu);
        };
        match memory.parse::<u64>() {
            Ok(mebibytes @ 1..=0xfff_ffff) => Ok(gpu.with_memory(mebibytes << 20)),
            _ => Err(GpuError::NotOpened(format!(
                "{MEMORY} is {memory:?}; expected a whole number of MiB, 1 or more"
            ))),
        }
    }

    /// Opens the first adapter whose name contains `name`, or the fastest kind of adapter.
    ///
    /// # Errors
    /// If there is no such adapter, or it cannot be opened.
    pub fn open(name: Option<&str>) -> Result<Self, GpuError> {
        let adapters = sorted();
        let named = |adapter: &&Adapter| {
            let found = adapter.get_info().name.to_lowercase();
            name.is_none_or(|name| found.contains(&name.to_lowercase()))
        };
        let Some(adapter) = adapters.iter().find(named) else {
            let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
            let wanted = name.map_or("any adapter".to_owned(), |name| {
                format!("an adapter with \"{name}\" in its name")
            });
            let found = match names.is_empty() {
                true => "found none".to_owned(),
                false => format!("found only {}", names.join(", ")),
            };
            return Err(GpuError::NoAdapter(format!(
                "looked for {wanted} of Vulkan, Metal or DirectX 12, and {found}"
            )));
        };
        let limits = adapter.limits();
        let wanted = DeviceDescriptor {
            required_limits: limits.clone(),
            ..DeviceDescriptor::default()
        };
        let (device, queue) = block_on(adapter.request_device(&wanted))
            .map_err(|e| GpuError::NotOpened(e.to_string()))?;
        let failed = Arc::new(OnceLock::new());
        let [lost, uncaptured] = [(); 2].map(|()| Arc::clone(&failed));
        device.set_device_lost_callback(move |reason, text| {
            let text = match text.trim_end_matches('.') {
                "" => format!("{reason:?}"),
                text => text.to_owned(),
            };
            let _ = lost.set(format!("the device was lost: {text}"));
        });
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            // Messages of errors have several lines.
            let text = error.to_string();
            let words: Vec<&str> = text.split_whitespace().collect();
            let _ = uncaptured.set(words.join(" "));
        }));
        let adapter = adapter.get_info();
        Ok(Self {
            groups: groups(&device),
            device,
            queue,
            memory: match adapter.device_type {
                DeviceType::DiscreteGpu => 4 << 30,
                _ => 1 << 30,
            },
            adapter,
            limits,
            failed,
        })
    }

    /// This device with a budget of memory for the buffers of a population, in bytes. It is 4 GiB for a card of its own,
    /// and 1 GiB for others: a device does not tell how much memory it has.
    #[must_use]
    pub fn with_memory(self, memory: u64) -> Self {
        Self { memory, ..self }
    }

    /// The budget of memory for the buffers of a population, in bytes.
    pub fn memory(&self) -> u64 {
        self.memory
    }

    /// Gives the device up. Everything that it is asked afterwards fails, as if the adapter were lost.
    pub fn give_up(&self) {
        self.device.destroy();
    }

    /// The memory of a workgroup, in bytes.
    pub fn memory_of_workgroup(&self) -> usize {
        self.limits.max_compute_workgroup_storage_size as usize
    }

    /// Returns the error that the device has reported, if there is one.
    fn checked(&self) -> Result<(), GpuError> {
        match self.failed.get() {
            Some(failed) => Err(GpuError::Failed(failed.clone())),
            None => Ok(()),
        }
    }

    /// The name and kind of the adapter.
    pub fn adapter(&self) -> &wgpu::AdapterInfo {
        &self.adapter
    }

    /// How many steps a dispatch should take.
    pub(crate) fn steps_at_once(&self) -> usize {
        match self.adapter.device_type {
            // Mesa's driver silently leaves all loops of an invocation after 65535 turns.
            DeviceType::Cpu => 16,
            _ => 256,
        }
    }

    /// The largest buffer that a program can read, in bytes.
    pub(crate) fn largest_buffer(&self) -> u64 {
        self.limits
            .max_buffer_size
            .min(self.limits.max_storage_buffer_binding_size)
    }

    /// Compiles the first entry points of a program: `forward`, or both.
    pub(crate) fn compile(
        &self,
        printed: &Printed,
        count: usize,
    ) -> Result<Vec<ComputePipeline>, GpuError> {
        let most = self.memory_of_workgroup();
        let needed = printed.memory()[count - 1];
        if needed > most {
            return Err(GpuError::TooLarge(format!(
                "its numbers take {needed} bytes of a workgroup's memory, of which the GPU has {most}"
            )));
        }
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let text = ShaderModuleDescriptor {
            label: None,
            source: ShaderSource::Wgsl(printed.source().into()),
        };
        // SAFETY: checks of indices and of loops take half of the time. `wgsl` prints every index as a constant place
        // plus a loop variable below the length of the array, or as an entry of a table that it has made itself; all loops
        // end after a fixed number of turns. `Population` makes the buffers in the lengths that the program states.
        #[allow(unsafe_code)]
        let module = unsafe {
            let unchecked = wgpu::ShaderRuntimeChecks::unchecked();
            self.device.create_shader_module_trusted(text, unchecked)
        };
        let layout = self
            .device
            .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&self.groups)],
                immediate_size: 0,
            });
        let pipeline = |entry: &str| {
            self.device
                .create_compute_pipeline(&ComputePipelineDescriptor {
                    label: Some(entry),
                    layout: Some(&layout),
                    module: &module,
                    entry_point: Some(entry),
                    compilation_options: PipelineCompilationOptions {
                        // Every number is written before it is read.
                        zero_initialize_workgroup_memory: false,
                        ..PipelineCompilationOptions::default()
                    },
                    cache: None,
                })
        };
        let pipelines = ["forward", "reverse"][..count].iter();
        let pipelines = pipelines.map(|entry| pipeline(entry)).collect();
        match block_on(scope.pop()) {
            None => self.checked().map(|()| pipelines),
            Some(error) => Err(GpuError::Refused(
                error.to_string(),
                printed.source().to_owned(),
            )),
        }
    }

    pub(crate) fn bind(&self, buffers: [&Buffer; BINDINGS as usize]) -> BindGroup {
        let entries = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            });
        let entries: Vec<_> = entries.collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.groups,
            entries: &entries,
        })
    }

    fn allocate(&self, size: u64, usage: BufferUsages) -> Buffer {
        self.device.create_buffer(&BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        })
    }

    /// A buffer for this many numbers, at least one, filled with zeros.
    pub(crate) fn buffer(&self, numbers: usize) -> Buffer {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        self.allocate(4 * numbers.max(1) as u64, usage)
    }

    /// The buffer of the uniform `plan`.
    pub(crate) fn plan(&self) -> Buffer {
        self.allocate(48, BufferUsages::UNIFORM | BufferUsages::COPY_DST)
    }

    /// A buffer with these numbers.
    pub(crate) fn filled<T: bytemuck::Pod>(&self, numbers: &[T]) -> Buffer {
        let buffer = self.buffer(numbers.len());
        self.write(&buffer, 0, numbers);
        buffer
    }

    /// Writes numbers from the number `at` on.
    pub(crate) fn write<T: bytemuck::Pod>(&self, buffer: &Buffer, at: usize, numbers: &[T]) {
        if !numbers.is_empty() {
            self.queue
                .write_buffer(buffer, 4 * at as u64, bytemuck::cast_slice(numbers));
        }
    }

    /// Fills buffers with zeros.
    pub(crate) fn clear(&self, buffers: &[&Buffer]) {
        self.submit(|commands| {
            buffers
                .iter()
                .for_each(|buffer| commands.clear_buffer(buffer, 0, None));
        });
    }

    fn submit(&self, record: impl FnOnce(&mut CommandEncoder)) {
        let mut commands = self.device.create_command_encoder(&Default::default());
        record(&mut commands);
        self.queue.submit([commands.finish()]);
    }

    /// Reads the first numbers of a buffer, after all work before has ended.
    pub(crate) fn read(&self, buffer: &Buffer, numbers: usize) -> Result<Vec<f32>, GpuError> {
        if numbers == 0 {
            return Ok(Vec::new());
        }
        let size = 4 * numbers as u64;
        let copy = self.allocate(size, BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        self.submit(|commands| commands.copy_buffer_to_buffer(buffer, 0, &copy, 0, size));
        copy.map_async(wgpu::MapMode::Read, .., |_| {});
        self.wait()?;
        self.checked()?;
        let view = copy
            .get_mapped_range(..)
            .map_err(|e| GpuError::Failed(e.to_string()))?;
        Ok(bytemuck::cast_slice(&view).to_vec())
    }

    /// Waits until all work has ended.
    pub fn wait(&self) -> Result<(), GpuError> {
        let waited = self.device.poll(PollType::wait_indefinitely());
        self.checked()?;
        waited
            .map(|_| ())
            .map_err(|e| GpuError::Failed(e.to_string()))
    }

    /// Starts an entry point for this many members.
    pub(crate) fn start(&self, pipeline: &ComputePipeline, bound: &BindGroup, members: usize) {
        self.submit(|commands| {
            let mut pass = commands.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, bound, &[]);
            let rows = members.div_ceil(GROUPS_IN_A_ROW);
            pass.dispatch_workgroups(members.min(GROUPS_IN_A_ROW) as u32, rows as u32, 1);
        });
    }
}

/// The number of bindings of a printed program.
const BINDINGS: u32 = 10;

/// The bindings of a printed program.
fn groups(device: &Device) -> wgpu::BindGroupLayout {
    let entry = |binding: u32| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: match binding {
                0 => wgpu::BufferBindingType::Uniform,
                _ => wgpu::BufferBindingType::Storage {
                    read_only: binding <= 4,
                },
            },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries: Vec<_> = (0..BINDINGS).map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    })
}
