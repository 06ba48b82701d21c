use cosmic::policy::{Block, Controller, Weights};

fn blocks() -> [Block; 4] {
    [
        Block::weights("w1", 2, 3, 1.0),
        Block::biases("b1", 2),
        Block::weights("w2", 1, 2, 1.0),
        Block::biases("b2", 1),
    ]
}

fn controller() -> Controller<f64> {
    Controller::new(&blocks(), (0..11).map(|k| 0.5 * f64::from(k)).collect())
}

#[test]
fn matrices_are_lists_of_rows() {
    let text = serde_json::to_string(&Weights::from(&controller())).unwrap();
    let expected = "{\"w1\":[[0.0,0.5,1.0],[1.5,2.0,2.5]],\"b1\":[3.0,3.5],\"w2\":[[4.0,4.5]],\
                    \"b2\":[5.0]}";
    assert_eq!(text, expected);
    let read: Weights = serde_json::from_str(&text).unwrap();
    assert_eq!(read.controller(&blocks(), "a file").unwrap(), controller());
    assert_eq!(serde_json::to_string(&controller()).unwrap(), text);
    let read: Controller<f64> = serde_json::from_str(&text).unwrap();
    assert_eq!(read, controller());
    let ragged = serde_json::from_str::<Controller<f64>>("{\"w1\":[[0.0],[1.0,2.0]]}");
    let says = ragged.unwrap_err().to_string();
    assert!(says.contains("the rows of `w1` differ in length"), "{says}");
}

#[test]
#[should_panic(expected = "the controller has no block \"w\"")]
fn an_unknown_block_is_named() {
    let _ = controller().block("w");
}

#[test]
fn a_block_that_is_not_the_policy_s_is_named() {
    let weights = Weights::from(&controller());
    let says = |blocks: &[Block]| weights.controller(blocks, "f").unwrap_err().to_string();
    assert!(says(&blocks()[..3]).contains("unknown block `controller.b2`"));
    let more = [&blocks()[..], &[Block::biases("b3", 1)]].concat();
    assert!(says(&more).contains("`controller.b3` is missing"));
    let mut other = blocks();
    other[1] = Block::biases("b1", 3);
    assert!(says(&other).contains("entries in `controller.b1`"));
}
