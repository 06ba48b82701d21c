use cosmic_lab::sweep::claim::{Answer, Pace, claim};
use std::fs;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

const FAST: Pace = Pace {
    beat: Duration::from_millis(10),
    gone_after: Duration::from_millis(400),
};

fn is_granted(sweep: &Path) -> bool {
    matches!(claim(sweep, "a-0", FAST).unwrap(), Answer::Granted(_))
}

/// Writes the file of a claim with a host and a count.
fn write(path: &Path, host: &str, count: u64) {
    fs::write(path, format!("{host}\n1 {count:020}\n")).unwrap();
}

/// Makes the file of a claim that another host holds. This host does not see the locks of the other host.
fn foreign(sweep: &Path) -> PathBuf {
    let folder = sweep.join("claims/a-0");
    fs::create_dir_all(&folder).unwrap();
    let path = folder.join("7");
    write(&path, "elsewhere 123", 0);
    path
}

#[test]
fn a_claim_is_granted_once_and_again_when_it_is_given_back() {
    let sweep = tempfile::tempdir().unwrap();
    let held = claim(sweep.path(), "a-0", FAST).unwrap();
    assert!(matches!(held, Answer::Granted(_)));
    let text = fs::read_to_string(sweep.path().join("claims/a-0/1")).unwrap();
    assert!(!is_granted(sweep.path()));
    drop(held);
    assert!(is_granted(sweep.path()));
    // The file now looks like that of a killed process of this host: the lock is released, but the claim was not
    // given back. Without locks, the host is `-`.
    let own = text.lines().next().unwrap();
    write(&foreign(sweep.path()), own, 0);
    assert!(own == "-" || is_granted(sweep.path()));
}

#[test]
fn a_holder_elsewhere_is_gone_when_its_count_stands_still() {
    let sweep = tempfile::tempdir().unwrap();
    let held = foreign(sweep.path());
    let answer = || claim(sweep.path(), "a-0", FAST).unwrap();
    assert!(matches!(answer(), Answer::Watched));
    for count in 1..12 {
        sleep(FAST.gone_after / 8);
        write(&held, "elsewhere 123", count);
        assert!(!is_granted(sweep.path()));
    }
    assert!(matches!(answer(), Answer::Taken));
    sleep(FAST.gone_after);
    assert!(is_granted(sweep.path()));
}

#[test]
fn a_holder_that_stood_still_learns_that_it_was_replaced() {
    let sweep = tempfile::tempdir().unwrap();
    let Answer::Granted(held) = claim(sweep.path(), "a-0", FAST).unwrap() else {
        panic!("no other process holds it");
    };
    assert!(!held.is_lost());
    fs::write(sweep.path().join("claims/a-0/2"), "elsewhere 123\n").unwrap();
    while !held.is_lost() {
        sleep(FAST.beat);
    }
}
