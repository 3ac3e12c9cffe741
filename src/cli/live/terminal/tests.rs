use super::*;

fn canvas(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Canvas {
    Canvas { crop: Crop { x: 0, y: 0, width, height }, width, height, pixels }
}

const BLOCKS: Terminal =
    Terminal { protocol: Protocol::HalfBlocks, size: [120, 40], cell: [10, 20] };

/// Two pixels to a character, the upper one in front; 0.5 is 188 in sRGB.
#[test]
fn half_blocks_are_two_pixels() {
    let pixels = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5; 3]];
    assert_eq!(
        BLOCKS.draw(&canvas(2, 2, pixels), 7),
        "\x1b[38;2;255;0;0;48;2;0;0;255m▀\x1b[38;2;0;255;0;48;2;188;188;188m▀\x1b[0m\x1b[K\n"
    );
}

/// The mean is that of light, not of bytes.
#[test]
fn pixels_are_means_of_light() {
    let pixels = vec![[1.0; 3], [0.0; 3], [1.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]];
    assert_eq!(canvas(2, 3, pixels.clone()).scaled(1, 1), [[156; 3]]);
    assert_eq!(canvas(2, 3, pixels.clone()).scaled(1, 3), [[188; 3], [188; 3], [0; 3]]);
    // More than there are: some twice.
    assert_eq!(canvas(2, 3, pixels).scaled(4, 3)[..4], [[255; 3], [255; 3], [0; 3], [0; 3]]);
}

#[test]
fn kitty_gets_chunks() {
    let terminal = Terminal { protocol: Protocol::Kitty, ..BLOCKS };
    assert_eq!(
        terminal.draw(&canvas(2, 1, vec![[1.0; 3], [0.0; 3]]), 7),
        "\n\x1b[1A\x1b_Ga=T,f=24,s=2,v=1,c=2,r=1,i=7,p=1,q=2,C=1,m=0;////AAAA\x1b\\\x1b[1B"
    );
    let text = kitty(&[[0; 3]; 2000], [50, 40], [5, 2], 9);
    let chunks: Vec<_> = text.split_terminator("\x1b\\").collect();
    assert_eq!(chunks.len(), 2);
    let first = chunks[0].strip_prefix("\x1b_Ga=T,f=24,s=50,v=40,c=5,r=2,i=9,p=1,q=2,C=1,m=1;");
    assert_eq!(first.map(str::len), Some(4096));
    let second = chunks[1].strip_prefix("\x1b_Gm=0;");
    assert_eq!(second.map(str::len), Some(8000 - 4096));
}

/// The picture keeps its shape and leaves lines free, in any terminal.
#[test]
fn pictures_fit() {
    for (size, film, expected) in [
        ([120, 40], [800, 600], [80, 30]),
        ([60, 40], [800, 600], [60, 23]),
        ([120, 24], [800, 600], [56, 21]),
        ([120, 40], [100, 4000], [1, 37]),
        ([120, 40], [4000, 10], [80, 1]),
        ([120, 40], [10, 10], [10, 5]),
        ([1, 1], [800, 600], [1, 1]),
    ] {
        assert_eq!(Terminal { size, ..BLOCKS }.fit(film), expected, "{size:?} {film:?}");
    }
    // Characters of kitty are as wide as it says.
    let kitty = Terminal { protocol: Protocol::Kitty, cell: [10, 10], ..BLOCKS };
    assert_eq!(kitty.fit([100, 40]), [80, 32]);
}

#[test]
fn terminals_say_what_they_have() {
    for (term, program, expected) in [
        ("xterm-kitty", "", Some(Protocol::Kitty)),
        ("xterm-256color", "WezTerm", Some(Protocol::Kitty)),
        ("xterm-ghostty", "ghostty", Some(Protocol::Kitty)),
        ("xterm-256color", "", Some(Protocol::HalfBlocks)),
        ("", "", Some(Protocol::HalfBlocks)),
        ("tmux-256color", "WezTerm", Some(Protocol::HalfBlocks)),
        ("dumb", "", None),
    ] {
        assert_eq!(protocol(term, program), expected, "{term} {program}");
    }
}
