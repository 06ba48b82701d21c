use cosmic::policy::{Block, Controller};

#[test]
fn a_block_is_a_part_of_the_numbers() {
    let blocks = [Block::weights("turn", 2, 2, 1.0), Block::biases("shift", 1)];
    let mut controller = Controller::new(&blocks, vec![1.0, 2.0, 3.0, 4.0, 5.0]);
    controller.block_mut("shift")[0] = 7.0;
    assert_eq!(controller.block("turn"), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(controller.numbers(), [1.0, 2.0, 3.0, 4.0, 7.0]);
}

#[test]
#[should_panic(expected = "the controller has no block \"w\"")]
fn an_unknown_block_is_named() {
    let _ = Controller::new(&[Block::biases("shift", 1)], vec![1.0]).block("w");
}
