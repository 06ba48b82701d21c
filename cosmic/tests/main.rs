//! The tests of the crate `cosmic-codesign`. They form one binary. A file here tests the file of the same name in `src`;
//! other files test a topic.
//!
//! `cargo test -p cosmic-codesign --test all scene_reader::` runs one module.

mod case;
mod design {
    mod layout;
    mod snap;
    mod start;
    mod structure;
    mod tilt;
    mod vectors;
}
mod error;
mod geometry {
    mod ground;
    mod profile;
    mod segment;
    mod vector;
}
mod judge {
    mod delivery;
    mod quantiles;
    mod reach;
    mod reliability;
    mod verdict {
        mod hints;
        mod items;
        mod steps;
        mod walk;
    }
}
mod lattice {
    mod check;
    mod known;
    mod mirror;
}
mod laws {
    mod adjoints;
    mod built_in;
    mod bumpers;
    mod contacts;
    mod formula;
    mod kernels;
    mod walls;
}
mod numbers;
mod objective {
    mod augmented;
    mod displacement;
    mod measures;
    mod tasks;
}
mod outcome {
    mod summary;
}
mod parallel;
mod policy {
    mod mlp;
    mod saved;
    mod weighted;
}
mod projection;
mod property_design;
mod property_files;
mod reading;
mod record {
    mod carry_out;
    mod history {
        mod frames;
        mod write;
    }
    mod multistart;
    mod run {
        mod folder;
    }
}
mod record_files;
mod scene {
    mod declarations;
    mod departures;
    mod doubtful_trusses;
    mod fit;
    mod follow;
    mod generator;
    mod materials;
}
mod scene_builtin;
mod scene_reader;
mod scene_unread;
mod scene_values;
mod search {
    mod begin;
    mod iterate;
    mod passes;
    mod polish;
    mod review;
    mod schedule;
    mod settle;
    mod slope;
    mod slopes;
    mod windows;
}
mod small;
mod walk {
    mod loads;
}
mod world {
    mod draws;
    mod driven;
    mod run;
    mod stability {
        mod vibration;
    }
}
