//! What is measured, and what is said of it. Sentences take their figures, and their words where these
//! depend on figures, from the runs.

use telamon::measure::report::{self, rough, significant};
use telamon::measure::statistics::{bootstrap, median};
use telamon::measure::summary::Interval;

use crate::document::{share, times};
use crate::subject::Subject;
use crate::trial::{Choices, Measured, Trial};

/// A part of the document.
pub(crate) struct Section {
    /// Names it on the command line.
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    /// What is compared.
    pub(crate) question: &'static str,
    pub(crate) trials: &'static [Trial],
    /// Two sentences.
    pub(crate) shows: fn(&[Measured]) -> [String; 2],
}

const BOX: Subject = Subject::File("scenes/cornell-box.xml");
const VEACH: Subject = Subject::File("scenes/veach-mis.xml");

/// The document's parts.
pub(crate) static SECTIONS: &[Section] = &[
    Section {
        name: "branching",
        title: "Many rays at each bounce, or one",
        question: "The recursive estimator sends N rays from every vertex, the single sum one. Both find the \
                   lamp of the Cornell box by chance, with paths of up to three bounces and without roulette; the \
                   numbers of samples are such that all would trace as many rays if none left the box.",
        trials: &[Trial {
            name: "branching",
            subject: BOX,
            size: (12, 12),
            fixed: &[
                ("threads", "1"),
                ("strategy", "bsdf"),
                ("rr_policy", "none"),
                ("max_depth", "4"),
            ],
            settings: &[
                &[("integrator", "path"), ("spp", "8456")],
                &[("integrator", "branching"), ("branches", "4"), ("spp", "398")],
                &[("integrator", "branching"), ("branches", "8"), ("spp", "58")],
                &[("integrator", "branching"), ("branches", "16"), ("spp", "8")],
                &[("integrator", "branching"), ("branches", "32"), ("spp", "1")],
            ],
            reference: &[("strategy", "mis_power"), ("spp", "65536")],
            repeats: 8,
            builds: false,
            leaks: false,
        }],
        shows: branching,
    },
    Section {
        name: "roulette",
        title: "Russian roulette",
        question: "Paths in the Cornell box that end by leaving it alone, against paths that go on after each \
                   bounce with a fixed probability p, or with a probability that follows what the path still carries. \
                   Each at equal samples, and with four times as many.",
        trials: &[Trial {
            name: "roulette",
            subject: BOX,
            size: (48, 48),
            fixed: &[],
            settings: &[
                &[("rr_policy", "none"), ("spp", "256")],
                &[("rr_policy", "none"), ("spp", "64")],
                &[("rr_policy", "fixed:0.7"), ("rr_depth", "1"), ("spp", "64")],
                &[("rr_policy", "fixed:0.7"), ("rr_depth", "1"), ("spp", "256")],
                &[("rr_policy", "fixed:0.1"), ("rr_depth", "1"), ("spp", "64")],
                &[("rr_policy", "fixed:0.1"), ("rr_depth", "1"), ("spp", "256")],
                &[("rr_policy", "throughput"), ("rr_depth", "1"), ("spp", "64")],
                &[("rr_policy", "throughput"), ("rr_depth", "1"), ("spp", "256")],
            ],
            reference: &[("sampler", "sobol"), ("spp", "8192")],
            repeats: 8,
            builds: false,
            leaks: false,
        }],
        shows: roulette,
    },
    Section {
        name: "sampling",
        title: "Where directions come from",
        question: "First the Cornell box, whose lamp is found by chance: directions spread evenly over the \
                   hemisphere, against such as follow its cosine. Then Veach's scene: directions to lights alone, from the \
                   material alone, and both with multiple importance sampling by either heuristic.",
        trials: &[
            Trial {
                name: "directions",
                subject: BOX,
                size: (48, 48),
                fixed: &[("strategy", "bsdf")],
                settings: &[
                    &[("directions", "uniform"), ("spp", "256")],
                    &[("directions", "uniform"), ("spp", "64")],
                    &[("directions", "uniform"), ("spp", "16")],
                    &[("directions", "cosine"), ("spp", "16")],
                    &[("directions", "cosine"), ("spp", "64")],
                    &[("directions", "cosine"), ("spp", "256")],
                ],
                reference: &[("strategy", "mis_power"), ("sampler", "sobol"), ("spp", "4096")],
                repeats: 8,
                builds: false,
                leaks: false,
            },
            Trial {
                name: "strategies",
                subject: VEACH,
                size: (96, 64),
                fixed: &[],
                settings: &[
                    &[("strategy", "emitter"), ("spp", "64")],
                    &[("strategy", "emitter"), ("spp", "16")],
                    &[("strategy", "emitter"), ("spp", "4")],
                    &[("strategy", "bsdf"), ("spp", "4")],
                    &[("strategy", "bsdf"), ("spp", "16")],
                    &[("strategy", "bsdf"), ("spp", "64")],
                    &[("strategy", "mis_balance"), ("spp", "4")],
                    &[("strategy", "mis_balance"), ("spp", "16")],
                    &[("strategy", "mis_balance"), ("spp", "64")],
                    &[("strategy", "mis_power"), ("spp", "4")],
                    &[("strategy", "mis_power"), ("spp", "16")],
                    &[("strategy", "mis_power"), ("spp", "64")],
                ],
                reference: &[("strategy", "mis_power"), ("sampler", "sobol"), ("spp", "4096")],
                repeats: 8,
                builds: false,
                leaks: false,
            },
        ],
        shows: sampling,
    },
    Section {
        name: "precision",
        title: "Fast, robust or watertight",
        question: "Embree's robust and fast modes, and the Rust engine's watertight and plain tests, on a closed \
                   mesh: at the origin, and a thousand of its radii away, where 32-bit floats are a thousand times \
                   coarser. Beside the pictures, the rays that each gets wrong by the verdict of \
                   the referee of `telamon parity`, of such as are aimed at nothing and of such as are aimed at corners and sides.",
        trials: &[precision("precision-near", 0.0), precision("precision-far", 1000.0)],
        shows: precisions,
    },
    Section {
        name: "build",
        title: "The quality of the tree",
        question: "Embree's three qualities of build in its robust and in its fast mode, for a mesh of even triangles and \
                   for long thin ones in all directions, whose boxes overlap. Trees are built on all threads, once for each render.",
        trials: &[
            quality("build-even", Subject::Ball { away: 0.0 }, 192, &[("spp", "32")]),
            quality("build-thin", Subject::Needles, 64, &[("spp", "16")]),
        ],
        shows: builds,
    },
    Section {
        name: "sampler",
        title: "Independent numbers or Sobol's",
        question: "The Cornell box with numbers that know nothing of each other, and with Owen-scrambled Sobol \
                   points, which cover each pixel's paths evenly.",
        trials: &[Trial {
            name: "sampler",
            subject: BOX,
            size: (64, 64),
            fixed: &[],
            settings: &[
                &[("sampler", "independent"), ("spp", "256")],
                &[("sampler", "independent"), ("spp", "64")],
                &[("sampler", "independent"), ("spp", "16")],
                &[("sampler", "independent"), ("spp", "4")],
                &[("sampler", "sobol"), ("spp", "4")],
                &[("sampler", "sobol"), ("spp", "16")],
                &[("sampler", "sobol"), ("spp", "64")],
                &[("sampler", "sobol"), ("spp", "256")],
            ],
            reference: &[("sampler", "sobol"), ("spp", "8192")],
            repeats: 8,
            builds: false,
            leaks: false,
        }],
        shows: samplers,
    },
];

const ROBUST: &str = "backend=embree, robust=true";
const FAST: &str = "backend=embree, robust=false";
const WATERTIGHT: &str = "backend=rust, triangle=watertight";
const PLAIN: &str = "backend=rust, triangle=plain";

const fn precision(name: &'static str, away: f64) -> Trial {
    Trial {
        name,
        subject: Subject::Ball { away },
        size: (96, 96),
        fixed: &[("spp", "32")],
        settings: &[
            &[("backend", "embree"), ("robust", "true")],
            &[("backend", "embree"), ("robust", "false")],
            &[("backend", "rust"), ("triangle", "watertight")],
            &[("backend", "rust"), ("triangle", "plain")],
        ],
        reference: &[("sampler", "sobol"), ("spp", "1024")],
        repeats: 8,
        builds: false,
        leaks: true,
    }
}

const fn quality(name: &'static str, subject: Subject, side: u32, spp: Choices) -> Trial {
    Trial {
        name,
        subject,
        size: (side, side),
        fixed: spp,
        settings: &[
            &[("robust", "true"), ("quality", "medium")],
            &[("robust", "true"), ("quality", "low")],
            &[("robust", "true"), ("quality", "high")],
            &[("robust", "false"), ("quality", "medium")],
            &[("robust", "false"), ("quality", "low")],
            &[("robust", "false"), ("quality", "high")],
        ],
        reference: &[("sampler", "sobol"), ("spp", "512")],
        repeats: 8,
        builds: true,
        leaks: false,
    }
}

/// How many times what the base buys, by an error that no few pixels decide.
fn gain(measured: &Measured, label: &str) -> String {
    times(measured.of(label).compared_trimmed)
}

fn branching(measured: &[Measured]) -> [String; 2] {
    let m = &measured[0];
    let tree = [(4, 398), (8, 58), (16, 8), (32, 1)];
    let label = |(n, spp)| format!("integrator=branching, branches={n}, spp={spp}");
    let gains = tree.map(|t| gain(m, &label(t)));
    let deepest = |n: f64| 100.0 * n.powi(3) / (1.0 + n + n * n + n.powi(3));
    let widest = m.of(&label((32, 1))).compared_trimmed;
    let last = if widest.is_some_and(|c| c.differs && c.ratio.value < 1.0) {
        format!(
            "Rays multiply where a path carries least: with 32 branches up to {} % of all rays are the last of their path, \
             and all that a pixel sees is seen from one point, while the single sum draws anew from the camera on.",
            rough(deepest(32.0))
        )
    } else {
        "More branches are not worse here than the single sum.".to_owned()
    };
    [
        format!(
            "In the same time trees with 4, 8, 16 and 32 branches buy {}, {}, {} and {} of what the single sum buys.",
            gains[0], gains[1], gains[2], gains[3]
        ),
        last,
    ]
}

fn roulette(measured: &[Measured]) -> [String; 2] {
    let m = &measured[0];
    let label = |policy: &str, spp: u32| match policy {
        "none" => format!("rr_policy=none, spp={spp}"),
        _ => format!("rr_policy={policy}, rr_depth=1, spp={spp}"),
    };
    let error = |policy, spp| m.values(&label(policy, spp), |r| r.metrics.rel_mse_trimmed);
    let ratio = |policy, spp| around(&ratio(&error(policy, spp), &error("none", 64)));
    let gain = |policy| gain(m, &label(policy, 256));
    [
        format!(
            "At 64 samples p = 0.7 has {} times the error of paths without roulette and p = 0.1 {} times, and with four \
             times the samples they have {} and {} times that of 64 without.",
            ratio("fixed:0.7", 64),
            ratio("fixed:0.1", 64),
            ratio("fixed:0.7", 256),
            ratio("fixed:0.1", 256)
        ),
        format!(
            "In the same time (at 256 samples) p = 0.7 buys {} times what no roulette buys, p = 0.1 {} times, and a \
             probability that follows the throughput {} times.",
            gain("fixed:0.7"),
            gain("fixed:0.1"),
            gain("throughput")
        ),
    ]
}

fn sampling(measured: &[Measured]) -> [String; 2] {
    let [hemisphere, veach] = measured else { panic!("two trials") };
    let strategy = |name: &str| gain(veach, &format!("strategy={name}, spp=64"));
    [
        format!(
            "In the same time (at 256 samples) directions by the cosine buy {} times what even ones buy.",
            gain(hemisphere, "directions=cosine, spp=256")
        ),
        format!(
            "On Veach's scene, at 64 samples, the material's directions buy {} times what those to lights buy, and both \
             together {} times with the balance heuristic and {} times with the power heuristic.",
            strategy("bsdf"),
            strategy("mis_balance"),
            strategy("mis_power")
        ),
    ]
}

fn precisions(measured: &[Measured]) -> [String; 2] {
    let [near, far] = measured else { panic!("two trials") };
    let rate = |a: &str, b: &str| {
        let rates = |label: &str| near.values(label, |r| r.rays as f64 / r.seconds);
        around(&ratio(&rates(a), &rates(b)))
    };
    let wrong = |m: &Measured, label: &str| {
        let leaks = m.stored.leaks.iter().find(|l| l.setting == label).expect("was measured");
        format!("{} and {}", share(leaks.random), share(leaks.aimed))
    };
    let off = |m: &Measured, label: &str| {
        let bias = m.of(label).bias;
        let [value, error] = report::bias(&bias);
        format!("{value} ± {error}{}", if bias.is_biased { " (biased)" } else { "" })
    };
    let all = [ROBUST, FAST, WATERTIGHT, PLAIN];
    let [robust, fast, watertight, plain] = all.map(|label| wrong(near, label));
    let [far_robust, far_fast, far_watertight, far_plain] = all.map(|label| wrong(far, label));
    let offs = |m: &Measured| all.map(|label| off(m, label)).join(", ");
    [
        format!(
            "At the origin the fast mode traces {} times as many rays a second as the robust one and the plain test {} \
             times as many as the watertight one, and in this order, robust first, the pictures' means are off by {} \
             there and by {} a thousand radii away.",
            rate(FAST, ROBUST),
            rate(PLAIN, WATERTIGHT),
            offs(near),
            offs(far)
        ),
        format!(
            "Wrong for random and for aimed rays are {robust} in the robust mode and {fast} in the fast one, {watertight} \
             by the watertight test and {plain} by the plain one; a thousand radii away {far_robust}, {far_fast}, \
             {far_watertight} and {far_plain}."
        ),
    ]
}

fn builds(measured: &[Measured]) -> [String; 2] {
    let [even, thin] = measured else { panic!("two trials") };
    let label = |robust: bool, q: &str| format!("robust={robust}, quality={q}");
    let build = |m: &Measured, robust, q| {
        around(&ratio(m.builds(&label(robust, q)), m.builds(&label(robust, "medium"))))
    };
    let render = |m: &Measured, robust, q| {
        let seconds = |q| m.values(&label(robust, q), |r| r.seconds);
        ratio(&seconds(q), &seconds("medium"))
    };
    let both = |robust, q| {
        format!("{} and {}", around(&render(even, robust, q)), around(&render(thin, robust, q)))
    };
    let cases = [(false, "low"), (false, "high"), (true, "low"), (true, "high")];
    let differs = |i: Interval| !(i.low..=i.high).contains(&1.0);
    let told_apart = cases
        .iter()
        .filter(|&&(robust, q)| [even, thin].iter().any(|m| differs(render(m, robust, q))))
        .count();
    let verdict = match told_apart {
        0 => {
            "no tree renders faster or more slowly than the medium one beyond the noise".to_owned()
        }
        n => format!("{n} of these 4 pairs have an interval without 1"),
    };
    [
        format!(
            "A tree of high quality takes {} times as long to build as a medium one for even triangles and {} times for \
             thin ones in the fast mode, {} and {} in the robust one, and a tree of low quality {} and {} in the \
             fast mode.",
            build(even, false, "high"),
            build(thin, false, "high"),
            build(even, true, "high"),
            build(thin, true, "high"),
            build(even, false, "low"),
            build(thin, false, "low")
        ),
        format!(
            "To render even and thin triangles, low takes {} times and high {} times as long as medium in the fast mode, {} \
             and {} in the robust one: {verdict}.",
            both(false, "low"),
            both(false, "high"),
            both(true, "low"),
            both(true, "high")
        ),
    ]
}

/// `1.02 (0.99 to 1.04)`.
fn around(i: &Interval) -> String {
    format!("{} ({} to {})", significant(i.value), significant(i.low), significant(i.high))
}

/// Median of `a` over that of `b`, of the same rounds, with a bootstrap interval over these.
fn ratio(a: &[f64], b: &[f64]) -> Interval {
    let of = |rounds: &[usize]| {
        let middle = |values: &[f64]| median(rounds.iter().map(|&round| values[round]));
        middle(a) / middle(b)
    };
    let all: Vec<usize> = (0..a.len().min(b.len())).collect();
    let (low, high) = bootstrap(all.len(), 1, of);
    Interval { value: of(&all), low, high }
}

fn samplers(measured: &[Measured]) -> [String; 2] {
    let m = &measured[0];
    let gain = |spp: u32| gain(m, &format!("sampler=sobol, spp={spp}"));
    let slope = |label: &str| {
        let series = m.findings.series.iter().find(|s| s.label == label);
        let (slope, error) = series.and_then(|s| s.slope).expect("four points");
        format!("{slope:.2} ± {error:.2}").replace('-', "−")
    };
    [
        format!(
            "In the same time Sobol's points buy {} times what independent numbers buy at 4 samples, and {} times at 256.",
            gain(4),
            gain(256)
        ),
        format!(
            "Their RMSE falls as samples to the power {}, that of independent ones, of which −0.5 is expected, to the \
             power {}.",
            slope("sampler=sobol"),
            slope("sampler=independent")
        ),
    ]
}
