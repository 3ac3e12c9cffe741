//! Scenes of Nori beside the same scenes in Mitsuba's words.

mod support;

use telamon::film::picture::Picture;
use telamon::intersect::Backend;

use support::pictures::{in_package, picture, read};

/// Mirrored, none of it would be where it is.
#[test]
fn a_scene_of_noris_is_the_same_picture_to_the_last_bit() {
    let render = |name: &str| {
        let description = read(&in_package(&format!("tests/nori/{name}.xml")), &[]);
        Picture::from_film(&picture(&description, Backend::default())).channels
    };
    let [nori, mitsuba] = ["room", "room-mitsuba"].map(render);
    assert!(nori == mitsuba, "pictures differ");
    assert!(!nori.is_empty());
}
