//! The tests of the crate `cosmic-lab`. They form one binary. A file here tests the file of the same name in `src`.

mod child;
mod export {
    mod joint;
    mod layers;
    mod member;
    mod mujoco;
    mod stl;
}
mod measure {
    mod errands;
    mod walks;
}
mod report {
    mod bars;
    mod gait;
    mod lettering;
    mod motion;
    mod plot;
    mod sheet;
}
mod small;
mod statistics;
mod sweep {
    mod claim;
    mod frozen;
    mod grid;
    mod plan;
    mod ranges;
    mod state;
}
mod table {
    mod fill;
    mod grid;
    mod words;
}
mod check {
    mod accuracy;
    mod distance;
    mod gradient;
    mod stability;
}
mod walk;
