//! The tests of the crate `cosmic-lab`. They form one binary. A file here tests the file of the same name in `src`.

mod export {
    mod mujoco;
}
mod report {
    mod gait;
    mod motion;
    mod sheet;
    mod space;
}
mod small;
mod statistics;
mod sweep {
    mod grid;
    mod plan;
}
mod table {
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
