//! The handler with which XLA, which runs the programs of JAX, calls rollouts by its typed foreign-function interface.
//!
//! The structs mirror `xla/ffi/api/c_api.h` up to the last field that is read here. They are alike in the versions 0.1 to
//! 0.3 of the interface. XLA adds fields at the ends of structs.

#![allow(unsafe_code)] // XLA passes pointers.

use crate::arrays::Number;
use crate::errors::{bug, caught};
use crate::planned::{Array, rollouts};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::ffi::{CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::{NonNull, null, null_mut};
use std::slice;
use std::sync::atomic::{AtomicI32, Ordering};

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
/// The code of errors that have no code.
const UNKNOWN: c_int = 2;

/// The beginning of most structs.
#[repr(C)]
struct Head {
    size: usize,
    extension: *const Extension,
}

#[repr(C)]
struct Extension {
    size: usize,
    kind: c_int,
    next: *const Extension,
}

#[repr(C)]
struct Version {
    head: Head,
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
    head: Head,
    message: *const c_char,
    code: c_int,
}

#[repr(C)]
struct Api {
    head: Head,
    version: Version,
    internal: *const c_void,
    fail: unsafe extern "C" fn(*const Failure) -> *mut c_void,
}

/// Pointers, and a code for the type of each. The names of attributes come with the codes of their values.
#[repr(C)]
struct List<T> {
    head: Head,
    count: i64,
    kinds: *const c_int,
    items: *const *const T,
}

#[repr(C)]
struct Attributes {
    names: List<Name>,
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
    head: Head,
    dtype: c_int,
    data: *mut c_void,
    rank: i64,
    axes: *const i64,
}

/// A call of the handler.
#[repr(C)]
struct Frame {
    head: Head,
    api: *const Api,
    context: *const c_void,
    stage: c_int,
    arguments: List<Buffer>,
    results: List<Buffer>,
    attributes: Attributes,
}

/// The minor version of the interface that the handler claims to be written for.
static MINOR: AtomicI32 = AtomicI32::new(0);

/// Returns the handler for `jax.ffi.register_ffi_target`. Some versions of XLA accept only their own version 0.`minor`.
#[pyfunction]
pub(crate) fn xla_handler(py: Python, minor: i32) -> PyResult<Bound<PyCapsule>> {
    caught(|| {
        MINOR.store(minor, Ordering::Relaxed);
        let handler: unsafe extern "C" fn(*const Frame) -> *mut c_void = answer;
        let pointer = NonNull::new(handler as *mut c_void).expect("the address of a function");
        // SAFETY: a function exists until the process ends.
        unsafe { PyCapsule::new_with_pointer(py, pointer, c"xla._CUSTOM_CALL_TARGET") }
    })
}

/// Answers a call of XLA. Returns null, or an error that XLA then owns.
///
/// # Safety
/// `frame` and everything that it points to must be as `c_api.h` describes.
unsafe extern "C" fn answer(frame: *const Frame) -> *mut c_void {
    // SAFETY: as for this function.
    let run = || unsafe { run(frame) };
    let outcome = catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| Err(bug(&*panic)));
    let Err(message) = outcome else {
        return null_mut();
    };
    let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
    let failure = Failure {
        head: Head::of::<Failure>(),
        message: message.as_ptr(),
        code: UNKNOWN,
    };
    // SAFETY: calls that can fail have a table of functions. This one copies the message.
    unsafe { ((*(*frame).api).fail)(&raw const failure) }
}

/// # Safety
/// As for [`answer`].
unsafe fn run(frame: *const Frame) -> Result<(), String> {
    // SAFETY: each frame has a head, and an extension begins with its size and its kind.
    let (head, extension) = unsafe { (&(*frame).head, (*frame).head.extension.as_ref()) };
    if extension.is_some_and(|of| of.kind == METADATA) {
        // SAFETY: an extension of this kind has this type. XLA reads what is written here after the call.
        let metadata = unsafe { &mut *(*head.extension.cast::<MetadataExtension>()).metadata };
        metadata.version = Version {
            head: Head::of::<Version>(),
            major: 0,
            minor: MINOR.load(Ordering::Relaxed),
        };
        metadata.traits = 0;
        return Ok(());
    }
    head.check::<Frame>()?;
    // SAFETY: the frame has all fields of the struct.
    let frame = unsafe { &*frame };
    if frame.stage != EXECUTE {
        return Err(format!("rollouts have no stage {}", frame.stage));
    }
    // SAFETY: as for this function.
    unsafe {
        let plan = frame.attributes.number(b"plan")?;
        let mode = frame.attributes.number(b"mode")?;
        let by = frame.attributes.number(b"by")?;
        let (given, made) = (frame.arguments.all()?, frame.results.all()?);
        match given.first().map(|buffer| buffer.dtype) {
            Some(FLOAT32) => passed::<f32>([plan, mode, by], &given, &made),
            _ => passed::<f64>([plan, mode, by], &given, &made),
        }
    }
}

/// # Safety
/// As for [`answer`].
unsafe fn passed<R: Number>(
    attributes: [i32; 3],
    given: &[&Buffer],
    made: &[&Buffer],
) -> Result<(), String> {
    let arrays = given.iter().map(|buffer| {
        let (first, count, axes) = buffer.numbers::<R>()?;
        // SAFETY: as for this function.
        let numbers = unsafe { slice::from_raw_parts(first, count) };
        Ok(Array { numbers, axes })
    });
    let arrays: Vec<_> = arrays.collect::<Result<_, String>>()?;
    let places = made.iter().map(|buffer| {
        let (first, count, _) = buffer.numbers::<R>()?;
        // SAFETY: as for this function. Nothing else uses the memory of a result during the call.
        Ok(unsafe { slice::from_raw_parts_mut(first, count) })
    });
    let mut places: Vec<_> = places.collect::<Result<_, String>>()?;
    rollouts(attributes, &arrays, &mut places)
}

impl Head {
    /// The head of a struct for XLA.
    fn of<T>() -> Self {
        Self {
            size: size_of::<T>(),
            extension: null(),
        }
    }

    /// Checks that a struct from XLA has all fields of `T`. XLA does not count the padding at the end.
    fn check<T>(&self) -> Result<(), String> {
        match self.size + align_of::<T>() > size_of::<T>() {
            true => Ok(()),
            false => Err("this version of JAX has another foreign-function interface".to_owned()),
        }
    }
}

/// # Safety
/// There must be `count` items, which live for `'a`.
unsafe fn listed<'a, T>(first: *const T, count: usize) -> &'a [T] {
    match count {
        0 => &[],
        // SAFETY: as for this function.
        _ => unsafe { slice::from_raw_parts(first, count) },
    }
}

impl List<Buffer> {
    /// # Safety
    /// As for [`answer`].
    unsafe fn all(&self) -> Result<Vec<&Buffer>, String> {
        self.head.check::<Self>()?;
        let count = self.count as usize;
        // SAFETY: as for this function.
        let (kinds, items) = unsafe { (listed(self.kinds, count), listed(self.items, count)) };
        if kinds.iter().any(|&kind| kind != BUFFER) {
            return Err("a rollout takes and returns only arrays".to_owned());
        }
        // SAFETY: the kind of the item.
        let buffers = items.iter().map(|&item| unsafe { &*item });
        let checked = buffers.map(|buffer| buffer.head.check::<Buffer>().map(|()| buffer));
        checked.collect()
    }
}

impl Attributes {
    /// Returns an attribute that is a number.
    ///
    /// # Safety
    /// As for [`answer`].
    unsafe fn number(&self, name: &[u8]) -> Result<i32, String> {
        self.names.head.check::<Self>()?;
        let count = self.names.count as usize;
        for place in 0..count {
            // SAFETY: as for this function. The type of the value is checked before it is read.
            unsafe {
                let own = &**self.names.items.add(place);
                let value = *self.values.add(place);
                if listed(own.letters, own.length) == name
                    && *self.names.kinds.add(place) == SCALAR
                    && (*value).dtype == INT32
                {
                    return Ok((*value).value.cast::<i32>().read_unaligned());
                }
            }
        }
        let name = String::from_utf8_lossy(name);
        Err(format!("a rollout needs the attribute {name}, an int32"))
    }
}

impl Buffer {
    /// Returns the first number, how many numbers there are, and the lengths of the axes.
    fn numbers<R: Number>(&self) -> Result<(*mut R, usize, &[i64]), String> {
        let code = [FLOAT64, FLOAT32][usize::from(size_of::<R>() == 4)];
        // SAFETY: XLA's list of lengths has the length `rank`.
        let axes = unsafe { listed(self.axes, self.rank as usize) };
        match (axes.iter().product::<i64>(), self.data.cast::<R>()) {
            (0, _) => Ok((NonNull::dangling().as_ptr(), 0, axes)),
            (count, data) if self.dtype == code && data.is_aligned() && !data.is_null() => {
                Ok((data, count as usize, axes))
            }
            _ => Err("a rollout needs arrays of one type, float32 or float64".to_owned()),
        }
    }
}
