//! The options of a printed program, the program, and the reason why one is refused.

use std::error::Error;
use std::fmt::{self, Display};
use std::sync::Arc;

use autodiff_programs::CotangentBound;
use autodiff_programs::internal::{check_bounds, check_units};

use super::memory::Placed;

/// The number of workgroups in a row of a dispatch: member `m` is the workgroup with `x + GROUPS_IN_A_ROW y = m`.
pub const GROUPS_IN_A_ROW: usize = 32768;

/// How a program is printed.
#[derive(Clone, Debug)]
pub struct Options {
    /// The number of invocations that carry one member.
    pub workgroup: usize,
    /// The parameters that all members share, by their order of declaration.
    pub common: Vec<usize>,
    /// The parameters whose cotangents the reverse sweep computes, by their order of declaration.
    pub wanted: Vec<usize>,
    /// The numbers of the state that are observed; `None` for all.
    pub entries: Option<Vec<usize>>,
    /// For how many steps the reverse sweep keeps the inputs of layers, before it adds them to the cotangents of matrices.
    pub kept: usize,
    /// How much memory a workgroup has, in bytes. Arrays that do not fit are moved to the buffer `spilled`.
    pub memory: usize,
    /// Like [`Rollout::state_bound`](autodiff_programs::Rollout::state_bound): `forward` marks the members of which a number is not
    /// below the bound.
    pub state_bound: Option<f64>,
    /// Like [`Rollout::cotangent_bound`](autodiff_programs::Rollout::cotangent_bound).
    pub cotangent_bound: Option<CotangentBound>,
    /// Like [`Rollout::cotangent_units`](autodiff_programs::Rollout::cotangent_units).
    pub cotangent_units: Option<Arc<[f64]>>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            workgroup: 64,
            common: Vec::new(),
            wanted: Vec::new(),
            entries: None,
            kept: 4,
            memory: usize::MAX,
            state_bound: None,
            cotangent_bound: None,
            cotangent_units: None,
        }
    }
}

impl Options {
    /// Checks the options for a program with this many parameters and numbers in a state. A device would run the text
    /// without these checks.
    ///
    /// # Panics
    /// If an option does not fit the program.
    #[track_caller]
    pub(super) fn check(&self, parameters: usize, state: usize) {
        for (name, list) in [("common", &self.common), ("wanted", &self.wanted)] {
            assert!(
                list.iter().all(|&parameter| parameter < parameters),
                "`{name}` is {list:?}; each must be less than {parameters}, the number of parameters"
            );
        }
        if let Some(entries) = &self.entries {
            assert!(
                entries.iter().all(|&entry| entry < state),
                "`entries` is {entries:?}; each must be less than {state}, the length of a state"
            );
        }
        assert!(
            self.workgroup > 0 && self.kept > 0,
            "`workgroup` is {} and `kept` is {}; both must be 1 or more",
            self.workgroup,
            self.kept
        );
        check_bounds(self.state_bound, self.cotangent_bound);
        check_units(self.cotangent_units.as_deref(), state);
    }
}

/// A program as text, and what a caller needs to know to run it.
///
/// # Entry points
///
/// `forward` and `reverse` are compute shaders. Member `m` is the workgroup with `x + 32768 y = m`
/// ([`GROUPS_IN_A_ROW`]). Both advance all
/// members by the steps that the uniform `plan` names:
///
/// | field | meaning |
/// | --- | --- |
/// | `members` | the number of members |
/// | `first` | the first step |
/// | `steps` | the number of steps |
/// | `read` | the slot of the state before step `first` |
/// | `write` | `forward` writes the state after `every * k` of its steps to slot `write + k`; `reverse` reads the state before its step `k > 0` from slot `write + k` |
/// | `every` | see `write`; `reverse` takes it as 1 |
/// | `observed` | how many observed states of each member the buffer `observed` has room for |
/// | `observes` | 1 if `forward` writes observed states, else 0 |
///
/// The uniform has room for twelve numbers, because its size must be a multiple of 16 bytes.
///
/// # Buffers
///
/// All in group 0. Each member has a part of `own`, `carried`, `bars`, `observed` and `spilled`, one after the other.
///
/// | binding | name | numbers |
/// | --- | --- | --- |
/// | 0 | `plan` | the uniform |
/// | 1 | `inputs` | for each step its inputs, and then the number of the observed state after it, from 1 on, or 0 |
/// | 2 | `table` | [`table`](Self::table) |
/// | 3, 4 | `own`, `of_all` | the parameters, see [`parameters`](Self::parameters) |
/// | 5 | `states` | in each slot the states of all members, one after the other |
/// | 6 | `carried` | the cotangent of the state, which `reverse` reads and replaces; with a bound on states, `forward` adds 1 to a number of the state that was not below the bound |
/// | 7 | `bars` | the cotangents of parameters, to which `reverse` adds |
/// | 8 | `observed` | `forward` writes the observed numbers; `reverse` reads their cotangents in the same places |
/// | 9 | `spilled` | numbers of a step that do not fit the memory of a workgroup: [`spilled`](Self::spilled) for each member |
#[derive(Clone, Debug)]
pub struct Printed {
    // A device runs the text without checks of indices, in buffers of these lengths. So none of the fields is public.
    pub(super) source: String,
    pub(super) state: usize,
    pub(super) entries: usize,
    pub(super) inputs: usize,
    pub(super) parameters: Vec<Placed>,
    pub(super) lengths: [usize; 3],
    pub(super) table: Vec<u32>,
    pub(super) memory: [usize; 2],
    pub(super) spilled: usize,
}

impl Printed {
    /// The text.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// How many numbers a state has.
    pub fn state(&self) -> usize {
        self.state
    }

    /// How many numbers of a state are observed.
    pub fn entries(&self) -> usize {
        self.entries
    }

    /// How many inputs a step has.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// The parameters, in their order of declaration.
    pub fn parameters(&self) -> &[Placed] {
        &self.parameters
    }

    /// The lengths of a member's part of `own`, of `of_all`, and of a member's part of `bars`.
    pub fn lengths(&self) -> [usize; 3] {
        self.lengths
    }

    /// The whole numbers that the program reads.
    pub fn table(&self) -> &[u32] {
        &self.table
    }

    /// The memory of a workgroup that `forward` and `reverse` need, in bytes.
    pub fn memory(&self) -> [usize; 2] {
        self.memory
    }

    /// How many numbers of a step each member has in the buffer `spilled`.
    pub fn spilled(&self) -> usize {
        self.spilled
    }

    /// The program with another text.
    ///
    /// # Safety
    /// A device may run the text without checks. All of its indices must be within their arrays, and its loops must end.
    #[must_use]
    #[allow(unsafe_code)]
    pub unsafe fn with_source(self, source: String) -> Self {
        Self { source, ..self }
    }
}

/// The reason why a program cannot be printed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(pub(super) String);

impl Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "this program cannot be printed as WGSL: {}", self.0)
    }
}

impl Error for Refused {}
