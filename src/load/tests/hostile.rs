//! Hostile files: none needs more than its size explains.

use super::super::work;
use super::{SENSOR, load};

/// A file of some size.
type Text<'a> = &'a dyn Fn(usize) -> String;

/// Files made to need time or stack. Each is tried at some size and at the double: the steps that the loader
/// takes may no more than double, and a bit.
#[test]
fn hostile_scenes_take_steps_in_proportion() {
    let scene = |content: &str| format!("<scene version=\"3.0.0\">{content}{SENSOR}</scene>");
    let numbered = |f: &dyn Fn(usize) -> String, n: usize| (0..n).map(f).collect::<String>();
    let nested =
        |n: usize| format!("{}{}", "<bsdf type=\"twosided\">".repeat(n), "</bsdf>".repeat(n));
    let chain = |n: usize| {
        numbered(&|i| format!("<bsdf type='twosided' id='b{i}'><ref id='b{}'/></bsdf>", i + 1), n)
            + &format!("<bsdf type='diffuse' id='b{n}'/>")
    };
    let doubling = |n: usize| {
        let two = |i: usize| {
            let inner = format!("<ref id='b{}'/>", i + 1).repeat(2);
            format!("<bsdf type='twosided' id='b{i}'>{inner}</bsdf>")
        };
        let shape = "<shape type='disk'><ref id='b0'/></shape>";
        numbered(&two, n) + &format!("<bsdf type='diffuse' id='b{n}'/>{shape}")
    };
    let defaults = |n: usize| {
        let twice = |i: usize| format!("<default name='a{}' value='$a{i}$a{i}'/>", i + 1);
        format!("<default name='a0' value='xxxxxxxx'/>{}", numbered(&twice, n))
    };
    let values = |n: usize| {
        let long = format!("<default name='a' value='{}'/>", "x".repeat(60_000));
        long + &"<default name='b' value='$a'/>".repeat(n)
    };
    let parameters = |n: usize| {
        let own = |i: usize| format!("<default name='p{i}' value='{i}'/>");
        let used = |i: usize| format!("<shape type='$p{i}'/>");
        numbered(&own, n) + &numbered(&used, n)
    };
    let undefined = |n: usize| {
        let own = |i: usize| format!("<default name='p{i}' value='{i}'/>");
        numbered(&own, n) + &numbered(&|i| format!("<shape type='$q{i}'/>"), n)
    };
    let properties = |n: usize| {
        let floats = numbered(&|i| format!("<float name='f{i}' value='1'/>"), n);
        format!("<shape type='disk'>{floats}</shape>")
    };
    let textures = |n: usize| {
        let texture = "<texture type='checkerboard' name='reflectance'/>".repeat(n);
        let floats = numbered(&|i| format!("<float name='f{i}' value='1'/>"), n);
        format!(
            "<bsdf type='diffuse'><float name='reflectance' value='1'/>{floats}{texture}</bsdf>"
        )
    };
    let entities = "<!DOCTYPE x [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]>";
    let cases: [(&str, usize, Text<'_>, &str); 13] = [
        ("nested", 5_000, &|n| scene(&nested(n)), "nested more than 64 deep"),
        ("chain", 5_000, &|n| scene(&chain(n)), "inside each other more than 100 deep"),
        ("doubling", 30, &|n| scene(&doubling(n)), "inside bsdf `twosided` changes nothing"),
        ("defaults", 30, &|n| scene(&defaults(n)), "too long"),
        ("values", 600, &|n| scene(&values(n)), "parameters add more than 33554432 bytes"),
        ("parameters", 5_000, &|n| scene(&parameters(n)), "is not supported"),
        ("undefined", 5_000, &|n| scene(&undefined(n)), "undefined parameter"),
        ("entities", 1, &|n| format!("{entities}{}", scene(&" ".repeat(n))), "DTD"),
        (
            "references",
            5_000,
            &|n| scene(&numbered(&|i| format!("<ref id='x{i}'/>"), n)),
            "more problems",
        ),
        ("properties", 5_000, &|n| scene(&properties(n)), "more problems"),
        ("textures", 5_000, &|n| scene(&textures(n)), "more problems"),
        (
            "attributes",
            500,
            &|n| format!("<scene {}/>", numbered(&|i| format!("a{i}='1' "), n)),
            "lacks the attribute",
        ),
        (
            "crowded",
            500_000,
            &|n| format!("<scene {}/>", numbered(&|i| format!("a{i}='1' "), n)),
            "an element has more than 1000 attributes",
        ),
    ];
    for (name, size, text, message) in cases {
        let steps = [size, 2 * size].map(|size| {
            let text = text(size);
            work::take();
            let error = load(&text).expect_err(name).to_string();
            assert!(error.contains(message), "{name}: {}", &error[..error.len().min(2000)]);
            work::take()
        });
        let [once, twice] = steps;
        assert!(twice <= 2 * once + once / 10 + 100, "{name}: {once} steps, then {twice}");
        // Within what is looked at there is nothing that is not: a step is a thing of the file.
        let most = 100 * size as u64 + 10_000;
        assert!(once <= most, "{name}: {once} steps for {size}");
    }
    assert!(load("").expect_err("empty").to_string().contains("not well-formed"));
}

/// The test above would see a loop over all pairs.
#[test]
fn steps_of_pairs_are_more_than_double() {
    let pairs = |n: usize| {
        work::take();
        (0..n).for_each(|_| work::count(n));
        work::take()
    };
    assert!(pairs(2000) > 2 * pairs(1000) + pairs(1000) / 10 + 100);
}
