//! Rollouts for XLA, which runs the programs of JAX: a handler of its typed foreign-function interface.
//!
//! The structs mirror `xla/ffi/api/c_api.h` up to the last field that is read here. They have been the same in all
//! versions from 0.1 on.

#![allow(unsafe_code)] // XLA passes pointers.

use crate::arrays::Number;
use crate::asked::Asked;
use crate::errors::{InputError, bug};
use crate::simulator::{Simulator, span};
use cosmic::simulator::Span;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ffi::{CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::{NonNull, null, null_mut};
use std::slice;
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The extension with which XLA asks for the version of the interface.
const METADATA: c_int = 1;
/// The stage in which XLA passes arrays.
const EXECUTE: c_int = 3;
/// The only kind of arguments and results.
const BUFFER: c_int = 1;
/// The kind of attributes that are numbers.
const SCALAR: c_int = 3;
const INT32: c_int = 4;
const FLOAT32: c_int = 11;
const FLOAT64: c_int = 12;
/// The code of errors for which XLA has no better code.
const UNKNOWN: c_int = 2;

#[repr(C)]
struct Extension {
    size: usize,
    kind: c_int,
    next: *const Extension,
}

#[repr(C)]
struct Version {
    size: usize,
    extension: *const Extension,
    major: c_int,
    minor: c_int,
}

#[repr(C)]
struct Metadata {
    size: usize,
    version: Version,
    traits: u32,
}

#[repr(C)]
struct MetadataExtension {
    base: Extension,
    metadata: *mut Metadata,
}

#[repr(C)]
struct Failure {
    size: usize,
    extension: *const Extension,
    message: *const c_char,
    code: c_int,
}

#[repr(C)]
struct Api {
    size: usize,
    extension: *const Extension,
    version: Version,
    internal: *const c_void,
    fail: Option<unsafe extern "C" fn(*mut Failure) -> *mut c_void>,
}

#[repr(C)]
struct Buffers {
    size: usize,
    extension: *const Extension,
    count: i64,
    kinds: *const c_int,
    buffers: *const *const Buffer,
}

#[repr(C)]
struct Attributes {
    size: usize,
    extension: *const Extension,
    count: i64,
    kinds: *const c_int,
    names: *const *const Name,
    values: *const *const Scalar,
}

#[repr(C)]
struct Name {
    letters: *const u8,
    length: usize,
}

#[repr(C)]
struct Scalar {
    dtype: c_int,
    value: *const c_void,
}

#[repr(C)]
struct Buffer {
    size: usize,
    extension: *const Extension,
    dtype: c_int,
    data: *mut c_void,
    rank: i64,
    axes: *const i64,
}

/// A call of the handler.
#[repr(C)]
struct Frame {
    size: usize,
    extension: *const Extension,
    api: *const Api,
    context: *const c_void,
    stage: c_int,
    arguments: Buffers,
    results: Buffers,
    attributes: Attributes,
}

/// The minor version of the interface that the handler claims to be written for.
static MINOR: AtomicI32 = AtomicI32::new(0);

/// Returns the handler for `jax.ffi.register_ffi_target`. Some versions of XLA accept only their own version 0.`minor`.
#[pyfunction]
pub(crate) fn xla_handler(py: Python, minor: i32) -> PyResult<Bound<PyCapsule>> {
    MINOR.store(minor, Ordering::Relaxed);
    let handler: unsafe extern "C" fn(*const Frame) -> *mut c_void = answer;
    let pointer = NonNull::new(handler as *mut c_void).expect("the address of a function");
    // SAFETY: a function stays where it is.
    unsafe { PyCapsule::new_with_pointer(py, pointer, c"xla._CUSTOM_CALL_TARGET") }
}

/// Answers a call of XLA. Returns null, or an error that XLA then owns.
///
/// # Safety
/// `frame` and all that it points to must be as XLA's interface describes.
unsafe extern "C" fn answer(frame: *const Frame) -> *mut c_void {
    // SAFETY: the caller.
    let run = || unsafe { answered(frame) };
    let failed = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| Err(bug(&*panic)));
    let Err(message) = failed else {
        return null_mut();
    };
    let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
    let mut failure = Failure {
        size: size_of::<Failure>(),
        extension: null(),
        message: message.as_ptr(),
        code: UNKNOWN,
    };
    // SAFETY: the frame has its table of functions in each call that can fail.
    match unsafe { (*(*frame).api).fail } {
        // SAFETY: `failure` is as the function expects; it copies the message.
        Some(fail) => unsafe { fail(&raw mut failure) },
        None => null_mut(),
    }
}

/// # Safety
/// As for [`answer`].
unsafe fn answered(frame: *const Frame) -> Result<(), String> {
    // SAFETY: the caller. Only the head of the frame is read before its size is known.
    let (size, extension) = unsafe { ((*frame).size, (*frame).extension) };
    // SAFETY: an extension is null or begins with its kind.
    if let Some(of) = unsafe { extension.as_ref() }
        && of.kind == METADATA
    {
        // SAFETY: an extension of this kind has this type, and XLA waits for what is written.
        let metadata = unsafe { &mut *(*extension.cast::<MetadataExtension>()).metadata };
        metadata.version = Version {
            size: size_of::<Version>(),
            extension: null(),
            major: 0,
            minor: MINOR.load(Ordering::Relaxed),
        };
        metadata.traits = 0;
        return Ok(());
    }
    long_enough::<Frame>(size)?;
    // SAFETY: the frame has all fields of the struct.
    let frame = unsafe { &*frame };
    if frame.stage != EXECUTE {
        return Err(format!("rollouts have no stage {}", frame.stage));
    }
    // SAFETY: the caller.
    let (id, mode, by) = unsafe {
        let attributes = &frame.attributes;
        (
            attributes.number("plan")?,
            attributes.number("mode")?,
            attributes.number("by")?,
        )
    };
    let plan = plans().get(&id).cloned();
    let plan = plan.ok_or("the simulator of this compiled function no longer exists; keep it")?;
    // SAFETY: the caller.
    let (arguments, results) = unsafe { (frame.arguments.all()?, frame.results.all()?) };
    // SAFETY: the caller. XLA gives no memory to two results.
    let done = match arguments.first().map(|array| array.dtype) {
        Some(FLOAT32) => unsafe { plan.run::<f32>(mode, by as u32, &arguments, &results)? },
        _ => unsafe { plan.run::<f64>(mode, by as u32, &arguments, &results)? },
    };
    let says = |error: PyErr| Python::try_attach(|py| error.value(py).to_string());
    done.map_err(|error| says(error).unwrap_or_else(|| "Python has ended".to_owned()))
}

/// Checks that a struct of XLA has all fields of `T`. XLA adds fields at the end.
fn long_enough<T>(size: usize) -> Result<(), String> {
    // The size that XLA gives does not count padding at the end.
    match size + align_of::<T>() > size_of::<T>() {
        true => Ok(()),
        false => Err("this version of JAX has another foreign-function interface".to_owned()),
    }
}

/// Returns a list of XLA as a slice.
///
/// # Safety
/// There must be `count` items, which live for `'a`.
unsafe fn list<'a, T>(items: *const T, count: usize) -> &'a [T] {
    match count {
        0 => &[],
        // SAFETY: the caller.
        _ => unsafe { slice::from_raw_parts(items, count) },
    }
}

impl Buffers {
    /// # Safety
    /// As for [`answer`].
    unsafe fn all(&self) -> Result<Vec<&Buffer>, String> {
        long_enough::<Self>(self.size)?;
        let count = self.count as usize;
        // SAFETY: the caller.
        let (kinds, buffers) = unsafe { (list(self.kinds, count), list(self.buffers, count)) };
        if kinds.iter().any(|&kind| kind != BUFFER) {
            return Err("a rollout takes and returns arrays".to_owned());
        }
        // SAFETY: the caller.
        let buffers = buffers.iter().map(|&buffer| unsafe { &*buffer });
        let all = buffers.map(|buffer| long_enough::<Buffer>(buffer.size).map(|()| buffer));
        all.collect()
    }
}

impl Attributes {
    /// Returns an attribute that is a number.
    ///
    /// # Safety
    /// As for [`answer`].
    unsafe fn number(&self, name: &str) -> Result<i32, String> {
        long_enough::<Self>(self.size)?;
        let count = self.count as usize;
        // SAFETY: the caller.
        let names = unsafe { list(self.names, count) };
        // SAFETY: the caller.
        let spelled = |name: &Name| unsafe { list(name.letters, name.length) };
        // SAFETY: the caller.
        let place = names
            .iter()
            .position(|&own| spelled(unsafe { &*own }) == name.as_bytes());
        let place = place.ok_or_else(|| format!("a rollout needs the attribute {name}"))?;
        // SAFETY: the caller.
        let kind = unsafe { list(self.kinds, count)[place] };
        // SAFETY: the caller; the type is checked before the number is read.
        unsafe {
            let scalar = list(self.values, count)[place];
            match kind == SCALAR && (*scalar).dtype == INT32 {
                true => Ok((*scalar).value.cast::<i32>().read_unaligned()),
                false => Err(format!("the attribute {name} must be an int32")),
            }
        }
    }
}

impl Buffer {
    fn axes(&self) -> &[i64] {
        // SAFETY: XLA's list of axes has the length `rank`.
        unsafe { list(self.axes, self.rank as usize) }
    }

    /// Returns the first number, and how many there are.
    fn numbers<R: Number>(&self) -> Result<(*mut R, usize), String> {
        let code = [FLOAT64, FLOAT32][usize::from(size_of::<R>() == 4)];
        let data = self.data.cast::<R>();
        if self.dtype != code || !data.is_aligned() {
            return Err("a rollout needs arrays of one type, float32 or float64".to_owned());
        }
        Ok((data, self.axes().iter().product::<i64>() as usize))
    }
}

/// A rollout that JAX can compile. As long as this object exists, XLA finds it by its number.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Planned {
    /// The number of the rollout in this process.
    #[pyo3(get)]
    id: i32,
}

struct Plan {
    simulator: Py<Simulator>,
    span: Span,
    bounded: bool,
    /// The names of the arrays, and the number of axes that they have for one robot.
    arrays: Vec<(String, usize)>,
}

static PLANS: Mutex<BTreeMap<i32, Arc<Plan>>> = Mutex::new(BTreeMap::new());
static NEXT: AtomicI32 = AtomicI32::new(0);

fn plans() -> MutexGuard<'static, BTreeMap<i32, Arc<Plan>>> {
    PLANS.lock().unwrap_or_else(PoisonError::into_inner)
}

#[pymethods]
impl Planned {
    #[new]
    fn new(
        simulator: Py<Simulator>,
        observed: Vec<usize>,
        first: usize,
        bounded: bool,
        arrays: Vec<(String, usize)>,
    ) -> Self {
        let id = NEXT.fetch_add(1, Ordering::Relaxed);
        let plan = Plan {
            simulator,
            span: span(observed, first),
            bounded,
            arrays,
        };
        plans().insert(id, Arc::new(plan));
        Self { id }
    }
}

impl Drop for Planned {
    fn drop(&mut self) {
        // The plan is dropped after the lock.
        let _plan = plans().remove(&self.id);
    }
}

/// An array that XLA passes.
struct Given<'a, R> {
    numbers: &'a [R],
    /// How many robots the array has an axis for; `None` if all robots share it.
    robots: Option<usize>,
}

impl Plan {
    /// Runs the rollouts (mode 0), their derivatives in a direction (1) or their gradients (2). The arguments are the
    /// arrays of the plan, and in mode 1 the direction, in mode 2 the cotangents. An array with one axis more than one
    /// robot's has an own part for each robot.
    ///
    /// # Safety
    /// The buffers must be as XLA describes them, and those of the results must not overlap.
    unsafe fn run<R: Number>(
        &self,
        mode: i32,
        by: u32,
        arguments: &[&Buffer],
        results: &[&Buffer],
    ) -> Result<PyResult<()>, String> {
        let ranks: Vec<usize> = self.arrays.iter().map(|(_, rank)| *rank).collect();
        // Positions and velocities have axes for states, nodes and directions.
        let others = if mode == 2 { &[3, 3][..] } else { &ranks };
        let given = arguments
            .iter()
            .zip(ranks.iter().chain(others))
            .map(|(buffer, &rank)| {
                let (first, count) = buffer.numbers()?;
                let axes = buffer.axes();
                Ok(Given {
                    // SAFETY: the caller.
                    numbers: unsafe { list(first, count) },
                    robots: (axes.len() > rank).then(|| axes[0] as usize),
                })
            });
        let given: Vec<Given<R>> = given.collect::<Result<_, String>>()?;
        let made = results.iter().map(|buffer| {
            let (first, count) = buffer.numbers()?;
            // SAFETY: the caller.
            Ok(match count {
                0 => &mut [],
                _ => unsafe { slice::from_raw_parts_mut(first, count) },
            })
        });
        let mut made: Vec<&mut [R]> = made.collect::<Result<_, String>>()?;
        if given.len() < ranks.len() + if mode == 0 { 0 } else { others.len() } {
            return Err("a rollout got too few arrays".to_owned());
        }
        Ok(self.rollouts(mode, by, &given, &mut made))
    }

    fn rollouts<R: Number>(
        &self,
        mode: i32,
        by: u32,
        given: &[Given<R>],
        made: &mut [&mut [R]],
    ) -> PyResult<()> {
        let simulator = self.simulator.get();
        let robots = given.iter().filter_map(|array| array.robots).max();
        let robots = robots.unwrap_or(1);
        if robots == 0 {
            return Ok(());
        }
        let (inputs, others) = given.split_at(self.arrays.len());
        let (inputs, counts, lost) = self.finite(inputs, robots);
        let numbers: Vec<&[R]> = inputs.iter().map(|array| &**array).collect();
        let z = self.arrays.iter().position(|(name, _)| name == "z");
        let projection = z.map_or(Ok("none"), |z| simulator.projection_of(numbers[z], &lost))?;
        let sizes = &simulator.sizes;
        let span = match mode {
            2 => simulator.backwards(self.span.clone(), self.bounded),
            _ => self.span.clone(),
        };
        let asked = Asked::of(sizes, &numbers, &counts, robots, span, projection);
        let products = match (mode, others, &mut *made) {
            (0, [], [x, v]) => {
                if let (_, Some(interrupt)) = simulator.filled(&asked, [x, v])? {
                    return Err(interrupt);
                }
                Vec::new()
            }
            (1, tangents, [_, _]) => {
                let numbers: Vec<&[R]> = tangents.iter().map(|array| array.numbers).collect();
                let counts: Vec<_> = tangents
                    .iter()
                    .map(|each| each.robots.unwrap_or(1))
                    .collect();
                let span = self.span.clone();
                let along = Asked::of(sizes, &numbers, &counts, robots, span, "none");
                simulator.pushed(&asked, &along)?
            }
            (2, [x, v], _) => simulator.pulled(&asked, [x.numbers, v.numbers], by)?,
            _ => return Err(InputError::new_err("a rollout got arrays that do not fit")),
        };
        for (robot, is_lost) in lost.into_iter().enumerate() {
            // The numbers that belong to the results are the last ones: derivatives follow the states.
            let mut rest = products.get(robot).map_or(&[][..], |(_, numbers)| numbers);
            let is_absurd = products.get(robot).is_some_and(|(is_absurd, _)| *is_absurd);
            for array in made.iter_mut().rev() {
                let length = array.len() / robots;
                let own = &mut array[robot * length..][..length];
                if is_lost || is_absurd {
                    own.fill(R::lit(f64::NAN));
                } else if mode > 0 {
                    let (before, numbers) = rest.split_at(rest.len() - length);
                    own.copy_from_slice(numbers);
                    rest = before;
                }
            }
        }
        Ok(())
    }

    /// Replaces numbers that are not finite by 0, and such rows of `z` by void. Returns the numbers of each array, how
    /// many robots each describes, and which robots are lost, because they had such numbers.
    fn finite<'a, R: Number>(
        &self,
        arrays: &[Given<'a, R>],
        robots: usize,
    ) -> (Vec<Cow<'a, [R]>>, Vec<usize>, Vec<bool>) {
        let is_finite = |number: &R| Into::<f64>::into(*number).is_finite();
        let mut lost = vec![false; robots];
        let mut clean = |(array, (name, _)): (&Given<'a, R>, &(String, usize))| {
            if array.numbers.iter().all(is_finite) {
                return Cow::Borrowed(array.numbers);
            }
            let length = array.numbers.len() / array.robots.unwrap_or(1);
            for (robot, own) in array.numbers.chunks(length).enumerate() {
                match own.iter().all(is_finite) {
                    false if array.robots.is_none() => lost.fill(true),
                    is_whole => lost[robot] |= !is_whole,
                }
            }
            let mut numbers = array.numbers.to_vec();
            if name == "z" {
                let rows = numbers.as_chunks_mut().0.iter_mut();
                let rows = rows.filter(|row: &&mut [R; 3]| !row.iter().all(is_finite));
                rows.for_each(|row| *row = [R::one(), R::zero(), R::zero()]);
            }
            let others = numbers.iter_mut().filter(|number| !is_finite(number));
            others.for_each(|number| *number = R::zero());
            Cow::Owned(numbers)
        };
        let numbers = arrays.iter().zip(&self.arrays).map(&mut clean).collect();
        let counts = arrays.iter().map(|array| array.robots.unwrap_or(1));
        (numbers, counts.collect(), lost)
    }
}
