//! Damaged and hostile files: no panic, no endless work.

use std::path::Path;
use std::time::Instant;

use super::super::{LoadOptions, load_text};
use super::{SENSOR, load};

/// A scene with something of everything.
const SEED: &str = "<?xml version=\"1.0\"?>\n<!-- all -->\n<scene version=\"0.6.0\">\n\
<default name=\"spp\" value=\"4\"/><default name=\"r\" value=\"0.5\"/>\n\
<integrator type=\"aov\"><string name=\"aovs\" value=\"d:depth,n:sh_normal\"/><integrator type=\"path\">\
<integer name=\"maxDepth\" value=\"-1\"/></integrator></integrator>\n\
<sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/><string name=\"fovAxis\" value=\"diagonal\"/>\
<transform name=\"toWorld\"><scale value=\"2\"/><rotate y=\"1\" angle=\"30\"/>\
<lookAt origin=\"0 0 5\" target=\"0,0,0\" up=\"0 1 0\"/><matrix value=\"1 0 0 0 1 0 0 0 1\"/></transform>\
<film type=\"hdrfilm\"><integer name=\"width\" value=\"64\"/><integer name=\"cropWidth\" value=\"9\"/>\
<rfilter type=\"tent\"><float name=\"radius\" value=\"2\"/></rfilter></film>\
<sampler type=\"independent\"><integer name=\"sampleCount\" value=\"$spp\"/></sampler></sensor>\n\
<bsdf type=\"twosided\" id=\"two\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"$r, .1 .2\"/></bsdf>\
<bsdf type=\"conductor\"><string name=\"material\" value=\"Au\"/></bsdf></bsdf><alias id=\"two\" as=\"too\"/>\n\
<shape type=\"sphere\"><ref id=\"too\"/><point name=\"center\" x=\"1\" y=\"2\" z=\"3\"/></shape>\n\
<shape type=\"disk\"><bsdf type=\"dielectric\"><string name=\"intIOR\" value=\"bk7\"/></bsdf>\
<emitter type=\"area\"><spectrum name=\"radiance\" value=\"3\"/></emitter></shape>\n\
<shape type=\"cube\"><transform name=\"toWorld\"><translate x=\"1\"/></transform></shape>\n\
<emitter type=\"constant\"/><emitter type=\"point\"><point name=\"position\" value=\"1\"/></emitter>\n</scene>\n";

/// The same of Nori's.
const NORI_SEED: &str = "<scene>\n<integrator type=\"path_mats\"/><sampler type=\"independent\">\
<integer name=\"sampleCount\" value=\"3\"/></sampler>\n<camera type=\"perspective\"><float name=\"fov\" value=\"40\"/>\
<transform name=\"toWorld\"><scale value=\"-1,1,1\"/><rotate axis=\"0,1,0\" angle=\"9\"/>\
<lookat origin=\"0,0,5\" target=\"0,0,0\" up=\"0,1,0\"/></transform><integer name=\"width\" value=\"64\"/>\
<rfilter type=\"gaussian\"><float name=\"stddev\" value=\".4\"/></rfilter></camera>\n\
<mesh type=\"sphere\"><point name=\"center\" value=\"1 2 3\"/><bsdf type=\"microfacet\">\
<color name=\"kd\" value=\".2,.1,.3\"/><float name=\"alpha\" value=\".3\"/></bsdf></mesh>\n\
<mesh type=\"sphere\"><emitter type=\"area\"><color name=\"radiance\" value=\"1,2,3\"/></emitter></mesh>\n\
<emitter type=\"point\"><point name=\"position\" value=\"1,2,3\"/><color name=\"power\" value=\"9\"/></emitter>\n\
</scene>\n";

/// Pieces that are likely to matter in a scene file.
const PIECES: [&str; 24] = [
    "\"",
    "<",
    ">",
    "/>",
    "&",
    "$",
    "\\$",
    "$spp",
    "-",
    "1e308",
    "1e-320",
    "nan",
    "inf",
    "99999999999999999999",
    "-1",
    "0",
    "é",
    "\0",
    "<ref id=\"two\"/>",
    "<scene version=\"3.0.0\">",
    "type=\"cube\"",
    "<!--",
    "]]>",
    "value",
];

/// A small generator of numbers (SplitMix64), so that the mutations are the same everywhere.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % limit.max(1) as u64) as usize
    }
}

fn mutate(text: &str, random: &mut Random) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for _ in 0..=random.below(2) {
        let at = random.below(chars.len());
        let end = (at + random.below(12)).min(chars.len());
        let piece = PIECES[random.below(PIECES.len())].chars();
        match random.below(5) {
            0 => drop(chars.drain(at..end)),
            1 => drop(chars.splice(at..at, piece)),
            2 => drop(chars.splice(at..end, piece)),
            3 => {
                let copied: Vec<char> =
                    chars[at..(at + random.below(200)).min(chars.len())].to_vec();
                let to = random.below(chars.len());
                drop(chars.splice(to..to, copied));
            }
            _ => {
                // Another word of the same file: names, types and values change places.
                let from = random.below(chars.len());
                let word: Vec<char> =
                    chars[from..].iter().copied().take(random.below(12)).collect();
                drop(chars.splice(at..end, word));
            }
        }
        if chars.is_empty() {
            break;
        }
    }
    chars.into_iter().collect()
}

#[test]
fn mutated_scenes_never_panic() {
    for seed in [SEED, NORI_SEED] {
        mutations_never_panic(seed);
    }
}

fn mutations_never_panic(seed: &str) {
    let options = LoadOptions::default();
    load_text(seed, Path::new("a.xml"), &options).unwrap_or_else(|e| panic!("{e}"));
    let mut random = Random(1);
    let (mut loaded, mut refused) = (0, 0);
    for _ in 0..3000 {
        let text = mutate(seed, &mut random);
        match load_text(&text, Path::new("a.xml"), &options) {
            Ok(_) => loaded += 1,
            Err(error) => {
                assert!(!error.problems().is_empty());
                for problem in error.problems() {
                    assert!(!problem.message.is_empty());
                    if let Some(p) = &problem.position {
                        assert!(
                            p.source.get(p.span.clone()).is_some() && p.line >= 1 && p.column >= 1
                        );
                    }
                }
                refused += 1;
            }
        }
    }
    // Both sides must be exercised for this to mean something.
    assert!(loaded > 50 && refused > 500, "{loaded} loaded, {refused} refused");
}

/// Files made to need time or stack; each is answered within seconds, even unoptimised and on a busy
/// machine.
#[test]
fn hostile_scenes_are_answered_soon() {
    let scene = |content: &str| format!("<scene version=\"3.0.0\">{content}{SENSOR}</scene>");
    let n = 100_000;
    let numbered = |f: &dyn Fn(usize) -> String, n: usize| (0..n).map(f).collect::<String>();
    let nested = format!("{}{}", "<bsdf type=\"twosided\">".repeat(n), "</bsdf>".repeat(n));
    let chain =
        numbered(&|i| format!("<bsdf type='twosided' id='b{i}'><ref id='b{}'/></bsdf>", i + 1), n)
            + &format!("<bsdf type='diffuse' id='b{n}'/>");
    let doubling = numbered(
        &|i| {
            format!(
                "<bsdf type='twosided' id='b{i}'><ref id='b{0}'/><ref id='b{0}'/></bsdf>",
                i + 1
            )
        },
        60,
    ) + "<bsdf type='diffuse' id='b60'/><shape type='disk'><ref id='b0'/></shape>";
    let defaults = numbered(&|i| format!("<default name='a{}' value='$a{i}$a{i}'/>", i + 1), 60);
    let entities = "<!DOCTYPE x [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]>";
    for (name, text, message) in [
        ("nested", scene(&nested), "nested more than 64 deep"),
        ("chain", scene(&chain), "inside each other more than 100 deep"),
        ("doubling", scene(&doubling), "inside bsdf `twosided` changes nothing"),
        (
            "defaults",
            scene(&format!("<default name='a0' value='xxxxxxxx'/>{defaults}")),
            "too long",
        ),
        (
            "values",
            scene(&format!(
                "<default name='a' value='{}'/>{}",
                "x".repeat(60_000),
                "<default name='b' value='$a'/>".repeat(600)
            )),
            "parameters add more than 33554432 bytes to the scene",
        ),
        ("entities", format!("{entities}{}", scene("")), "DTD"),
        (
            "references",
            scene(&numbered(&|i| format!("<ref id='x{i}'/>"), n)),
            "and 99950 more problems",
        ),
        (
            "properties",
            scene(&format!(
                "<shape type='disk'>{}</shape>",
                numbered(&|i| format!("<float name='f{i}' value='1'/>"), n)
            )),
            "and 99950 more problems",
        ),
        (
            "attributes",
            format!("<scene {}/>", numbered(&|i| format!("a{i}='1' "), 2000)),
            "lacks the attribute",
        ),
        ("empty", String::new(), "not well-formed"),
    ] {
        let start = Instant::now();
        let error = load(&text).expect_err(name).to_string();
        assert!(error.contains(message), "{name}: {}", &error[..error.len().min(2000)]);
        assert!(start.elapsed().as_secs() < 20, "{name} took {:?}", start.elapsed());
    }
}
