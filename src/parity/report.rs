//! What a run has counted, and its tables.

use std::fmt::{self, Display, Formatter};
use std::iter::repeat;
use std::time::Duration;

use super::oracle::{Encounter, MOST_NEAR};
use super::{Class, Contender, Family, Query};

const CLASSES: usize = Class::ALL.len();
const FAMILIES: usize = Family::ALL.len();

/// How many answers may be faults: leaks, false or wrong hits, wrong distances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// The share of rays of the families that are not aimed at anything, in `[0, 1]`.
    pub random: f64,
    /// The share of the others ([`Family::is_aimed`]).
    pub aimed: f64,
}

impl Budget {
    /// Not one.
    pub const NONE: Self = Self { random: 0.0, aimed: 0.0 };

    /// Of Embree's robust test, which is watertight but for rays that are aimed: at a vertex the errors of the
    /// edges are independent, so that it may miss all triangles around it, and what it sees from the side
    /// it reports at any distance. Of random rays it loses 6·10⁻⁶ at slivers a million times as long as wide.
    pub const EMBREE_ROBUST: Self = Self { random: 1e-5, aimed: 1e-2 };

    /// Of modes that trade rays for speed.
    pub const FAST: Self = Self { random: 1e-3, aimed: 0.2 };
}

/// What a run has counted.
#[derive(Clone, Debug)]
pub struct Report {
    /// Rays fired through each engine.
    pub rays: u64,
    /// Of those, rays that left the range of f32 ([`Ray::is_traceable`](crate::ray::Ray::is_traceable)) and
    /// must hit nothing.
    pub untraceable: u64,
    /// Rays to which at least one answer was [`Class::Undecided`].
    pub undecided: u64,
    /// One for each query of each contender.
    pub rows: Vec<Row>,
}

/// One engine's answers to one query.
#[derive(Clone, Debug)]
pub struct Row {
    /// Number of the contender.
    pub contender: usize,
    /// Its name.
    pub name: String,
    /// What it was asked.
    pub query: Query,
    /// How many answers may be faults.
    pub budget: Budget,
    /// What was counted.
    pub tally: Tally,
}

/// Counts that add up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Answers of each class in the order of [`Class::ALL`], for each family in the order of
    /// [`Family::ALL`].
    pub by_family: [[u64; CLASSES]; FAMILIES],
    /// Answers that contradict those to the contender's first query: a hit and none, or another primitive.
    pub contradictions: u64,
    /// Largest error of a distance that the referee saw, over that of the primitive's farthest corner: of answers
    /// of class [`Class::Same`] to rays that are not aimed and do not start at the surface that they hit.
    pub largest_relative: f64,
    /// The same over what rounding explains.
    pub largest_of_bound: f64,
    /// Time that threads spent in the engine, summed.
    pub elapsed: Duration,
}

impl Tally {
    /// Answers of a class.
    #[must_use]
    pub fn count(&self, class: Class) -> u64 {
        self.by_family.iter().map(|counts| counts[class as usize]).sum()
    }

    /// All answers.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.by_family.iter().flatten().sum()
    }

    /// Leaks, false and wrong answers and wrong distances to rays of a family.
    #[must_use]
    pub fn faults_of(&self, family: Family) -> u64 {
        let counts = self.by_family[family as usize];
        Class::ALL.into_iter().filter(|c| c.is_fault()).map(|c| counts[c as usize]).sum()
    }

    /// The same to all rays.
    #[must_use]
    pub fn faults(&self) -> u64 {
        Family::ALL.into_iter().map(|f| self.faults_of(f)).sum()
    }

    /// The share of faults among the rays that were aimed, or among the others.
    #[must_use]
    pub fn fault_share(&self, aimed: bool) -> f64 {
        let families = || Family::ALL.into_iter().filter(|f| f.is_aimed() == aimed);
        let faults: u64 = families().map(|f| self.faults_of(f)).sum();
        let total: u64 = families().flat_map(|f| self.by_family[f as usize]).sum();
        faults as f64 / total.max(1) as f64
    }

    /// Takes note of the distance of a hit, against that of the true crossing.
    pub(super) fn note_error(&mut self, t: f32, truth: f64, of: &Encounter) {
        let Encounter { reach, span, .. } = of;
        let error = f64::from(t) - truth;
        let excused = if error > 0.0 { span.far - truth } else { truth - span.near };
        self.largest_relative = self.largest_relative.max(error.abs() / reach);
        self.largest_of_bound = self.largest_of_bound.max(error.abs() / excused);
    }

    fn add(&mut self, other: &Self) {
        let counts = self.by_family.iter_mut().flatten().zip(other.by_family.iter().flatten());
        counts.for_each(|(mine, theirs)| *mine += theirs);
        self.contradictions += other.contradictions;
        self.largest_relative = self.largest_relative.max(other.largest_relative);
        self.largest_of_bound = self.largest_of_bound.max(other.largest_of_bound);
        self.elapsed += other.elapsed;
    }
}

impl Row {
    /// Whether there are more faults than the budget allows.
    #[must_use]
    pub fn is_over_budget(&self) -> bool {
        self.tally.fault_share(false) > self.budget.random
            || self.tally.fault_share(true) > self.budget.aimed
    }

    /// Rays a second of one thread, in millions.
    #[must_use]
    pub fn million_rays_per_second(&self) -> f64 {
        self.tally.total() as f64 / self.tally.elapsed.as_secs_f64().max(1e-9) * 1e-6
    }
}

impl Report {
    pub(super) fn new(contenders: &[Contender<'_>]) -> Self {
        let rows = contenders.iter().enumerate().flat_map(|(contender, c)| {
            c.queries.iter().map(move |&query| Row {
                contender,
                name: c.name.clone(),
                query,
                budget: c.budget,
                tally: Tally::default(),
            })
        });
        Self { rays: 0, untraceable: 0, undecided: 0, rows: rows.collect() }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.untraceable += other.untraceable;
        self.undecided += other.undecided;
        let rows = self.rows.iter_mut().zip(&other.rows);
        rows.for_each(|(mine, theirs)| mine.tally.add(&theirs.tally));
    }

    /// The rows that have more faults than their budget allows.
    pub fn over_budget(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|r| r.is_over_budget())
    }

    /// The rows of each contender.
    fn contenders(&self) -> impl Iterator<Item = &[Row]> {
        self.rows.chunk_by(|a, b| a.contender == b.contender)
    }
}

/// One line for each query of each engine, then one for each engine with its budget and where its faults
/// are.
impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let width = self.rows.iter().map(|r| r.name.chars().count()).max().unwrap_or(0);
        write!(f, "{:width$}  {:15}", "answers of", "to")?;
        Class::ALL.iter().try_for_each(|class| write!(f, " {:>10}", class.name()))?;
        writeln!(f, " {:>8}  {:>8}  {:>8}  {:>7}", "differs", "|Δt|/R", "of bound", "Mrays/s")?;
        for rows in self.contenders() {
            for (row, first) in rows.iter().zip([true].into_iter().chain(repeat(false))) {
                // Each name once.
                row.write(f, if first { &row.name } else { "" }, width)?;
            }
        }
        let Self { rays, untraceable, undecided, .. } = self;
        writeln!(
            f,
            "{rays} rays, {untraceable} of them outside the range of f32; differs: from the engine's \
             first answers; |Δt|/R: largest error of a distance over that of the farthest corner, of random rays with the same hit, and \
             the largest share of what rounding explains; Mrays/s: of one thread"
        )?;
        if *undecided > 0 {
            writeln!(
                f,
                "{undecided} rays that the referee could not decide: more than {MOST_NEAR} surfaces lie within \
                 the rounding of f32"
            )?;
        }

        write!(f, "\n{:width$}  {:>15}  {:>15}", "faults of", "budget", "worst query")?;
        Family::ALL.iter().try_for_each(|family| write!(f, " {:>8}", family.name()))?;
        writeln!(f)?;
        for rows in self.contenders() {
            let over = if rows.iter().any(Row::is_over_budget) { "  over budget" } else { "" };
            let shares = [false, true]
                .map(|aimed| rows.iter().map(|r| r.tally.fault_share(aimed)).fold(0.0, f64::max));
            let Budget { random, aimed } = rows[0].budget;
            let [budget, worst] = [[random, aimed], shares].map(|pair| pair.map(share).join(", "));
            write!(f, "{:width$}  {budget:>15}  {worst:>15}", rows[0].name)?;
            for family in Family::ALL {
                let faults: u64 = rows.iter().map(|r| r.tally.faults_of(family)).sum();
                write!(f, " {faults:>8}")?;
            }
            writeln!(f, "{over}")?;
        }
        let [random, aimed] = [false, true].map(|aimed| {
            let families = Family::ALL.into_iter().filter(|f| f.is_aimed() == aimed);
            families.map(Family::name).collect::<Vec<_>>().join(", ")
        });
        writeln!(
            f,
            "leak + false + wrong + distance of all queries; budget, worst query: their share of a query's rays that are \
             random ({random}) and that are aimed ({aimed})"
        )
    }
}

/// A share in few letters.
fn share(share: f64) -> String {
    if share == 0.0 { "0".to_owned() } else { format!("{share:.1e}") }
}

impl Row {
    fn write(&self, f: &mut Formatter<'_>, name: &str, width: usize) -> fmt::Result {
        let Self { query, tally, .. } = self;
        write!(f, "{name:width$}  {:15}", query.name())?;
        Class::ALL.iter().try_for_each(|&class| write!(f, " {:>10}", tally.count(class)))?;
        write!(f, " {:>8}", tally.contradictions)?;
        match query {
            Query::Closest | Query::ClosestBatch => {
                let Tally { largest_relative, largest_of_bound, .. } = tally;
                write!(f, "  {largest_relative:>8.1e}  {largest_of_bound:>8.2}")?;
            }
            Query::Occluded | Query::OccludedBatch => write!(f, "  {:8}  {:8}", "", "")?,
        }
        writeln!(f, "  {:>7.2}", self.million_rays_per_second())
    }
}
