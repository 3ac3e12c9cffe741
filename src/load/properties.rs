//! Objects as their constructors see them: checked, with defaults filled in from the table.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::context::{Context, lock};
use super::document::Place;
use super::graph::{Node, Property};
use super::image;
use super::indices;
use super::plugins::{self, Build, Category, Plugin};
use super::problem::Issue;
use super::values::Value;
use crate::bsdf::Bsdf;
use crate::math::{Motion, Rgb};
use crate::memory::Limits;
use crate::property::{Default, Kind};
use crate::texture::{Image, Texture, Textured};

/// An object that passed [`super::check::check`]: its properties have the kinds that the table says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Object<'a> {
    context: &'a Context<'a>,
    /// Its index in the graph, for an object that is there.
    index: Option<usize>,
    /// `None` for an object that the file leaves out: all properties have their defaults.
    node: Option<&'a Node>,
    plugin: &'static Plugin,
}

const IN_TABLE: &str = "constructors read what their table lists, of the kind that it lists";

impl<'a> Object<'a> {
    /// The object of that index.
    pub(super) fn new(context: &'a Context<'a>, index: usize) -> Option<Self> {
        let node = &context.graph.nodes[index];
        let plugin = plugins::find(node.category?, &node.plugin)?;
        Some(Self { context, index: Some(index), node: Some(node), plugin })
    }

    /// An object that the file leaves out.
    pub(super) fn left_out(self, plugin: &'static Plugin) -> Self {
        Self { index: None, node: None, plugin, ..self }
    }

    /// What tells it from all other objects; `None` if the file leaves it out.
    pub(super) fn index(&self) -> Option<usize> {
        self.index
    }

    /// Its row of the table.
    pub(super) fn plugin(&self) -> &'static Plugin {
        self.plugin
    }

    /// Its id; may be empty.
    pub(super) fn id(&self) -> &'a str {
        self.node.map_or("", |n| &n.id)
    }

    /// Where it stands.
    pub(super) fn place(&self) -> Place {
        self.node.map_or(Place::whole(0), |n| n.place)
    }

    /// Where its type stands.
    pub(super) fn place_of_type(&self) -> Place {
        self.node.map_or(Place::whole(0), |n| n.plugin_place)
    }

    /// Where the value of a property stands, or else the object.
    pub(super) fn place_of(&self, name: &str) -> Place {
        self.given(name).map_or(self.place(), |p| p.value_place)
    }

    /// Where the name of a property stands, or else the object.
    pub(super) fn place_of_name(&self, name: &str) -> Place {
        let texture = || self.texture_object(name).map(|o| o.place());
        let place = self.given(name).map(|p| p.name_place).or_else(texture);
        place.unwrap_or(self.place())
    }

    /// What its files may take.
    pub(super) fn limits(&self) -> &'a Limits {
        self.context.limits
    }

    /// When the shutter opens and closes.
    pub(super) fn shutter(&self) -> (f64, f64) {
        self.context.shutter()
    }

    /// The objects of a category inside it.
    pub(super) fn parts(&self, category: Category) -> impl Iterator<Item = Self> {
        let context = self.context;
        let children = self.node.map_or(&[][..], |n| &n.children);
        children
            .iter()
            .filter_map(move |c| Self::new(context, c.node))
            .filter(move |part| part.plugin.category() == category)
    }

    /// The first object of a category inside it, or else one with the defaults of `plugin`.
    pub(super) fn part_or(&self, category: Category, plugin: &'static Plugin) -> Self {
        self.parts(category).next().unwrap_or(self.left_out(plugin))
    }

    /// Whether the file gives a value.
    pub(super) fn has(&self, name: &str) -> bool {
        self.given(name).is_some() || self.texture_object(name).is_some()
    }

    /// Notes what may not be as meant.
    pub(super) fn warn(&self, issue: Issue) {
        lock(&self.context.warnings).push(issue);
    }

    /// An error if the file gives a value that `why` would have no effect.
    pub(super) fn refuse(&self, names: &[&str], why: &str) -> Result<(), Issue> {
        let Some(name) = names.iter().find(|name| self.has(name)) else {
            return Ok(());
        };
        Err(Issue::new(self.place_of_name(name), format!("`{name}` has no effect {why}")))
    }

    pub(super) fn boolean(&self, name: &str) -> bool {
        match (self.value(name), self.default(name)) {
            (Some(Value::Boolean(v)), _) => *v,
            (_, Default::Boolean(v)) => v,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    pub(super) fn integer(&self, name: &str) -> i64 {
        match (self.value(name), self.default(name)) {
            (Some(Value::Integer(v)), _) => *v,
            (_, Default::Integer(v)) => v,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    /// An integer that the table limits to what a u32 can hold.
    pub(super) fn count(&self, name: &str) -> u32 {
        u32::try_from(self.integer(name)).expect(IN_TABLE)
    }

    pub(super) fn float(&self, name: &str) -> f64 {
        match (self.number(name), self.default(name)) {
            (Some(v), _) | (_, Default::Float(v)) => v,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    /// A number, or `None` if the file gives none.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        match self.value(name) {
            Some(Value::Float(v)) => Some(*v),
            Some(Value::Integer(v)) => Some(*v as f64),
            _ => None,
        }
    }

    /// A text, or `None` if the file gives none and there is no default.
    pub(super) fn text(&self, name: &str) -> Option<&'a str> {
        match (self.value(name), self.default(name)) {
            (Some(Value::Text(v)), _) => Some(v),
            (_, Default::Text(v)) => Some(v),
            _ => None,
        }
    }

    /// One of the table's choices, as the table spells it.
    pub(super) fn choice(&self, name: &str) -> &'static str {
        let Some(Kind::Choice(names)) = self.plugin.property(name).map(|p| p.kind) else {
            unreachable!("{IN_TABLE}")
        };
        let text = self.text(name).expect(IN_TABLE);
        names.iter().find(|n| n.eq_ignore_ascii_case(text)).expect(IN_TABLE)
    }

    pub(super) fn point(&self, name: &str) -> DVec3 {
        match (self.value(name), self.default(name)) {
            (Some(Value::Point(v)), _) => *v,
            (_, Default::Origin) => DVec3::ZERO,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    /// A map; the identity in the place of one that changes while the shutter is open, which
    /// [`Object::motion`] tells.
    pub(super) fn transform(&self, name: &str) -> DAffine3 {
        match (self.value(name), self.default(name)) {
            (Some(Value::Transform(v)), _) => *v,
            (Some(Value::Animation(_)), _) => {
                self.in_shutter(name).and_then(|m| m.still()).unwrap_or_default()
            }
            (_, Default::Identity) => DAffine3::IDENTITY,
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    /// A map that changes while the shutter is open; `None` if it does not.
    pub(super) fn motion(&self, name: &str) -> Option<Motion> {
        self.in_shutter(name).filter(|motion| motion.still().is_none())
    }

    /// An animation in units of the shutter.
    fn in_shutter(&self, name: &str) -> Option<Motion> {
        let Some(Value::Animation(motion)) = self.value(name) else {
            return None;
        };
        let (open, close) = self.shutter();
        Some(motion.within(open, close))
    }

    pub(super) fn rgb(&self, name: &str) -> Rgb {
        match (self.value(name), self.number(name), self.default(name)) {
            (Some(Value::Rgb(v)), _, _) => v.as_vec3a(),
            (Some(Value::Spectrum(s)), _, _) => {
                let kind = self.plugin.property(name).expect(IN_TABLE).kind;
                let bounds = kind.color_bounds().expect(IN_TABLE);
                bounds.clamp(s.linear_srgb(self.plugin.light())).as_vec3a()
            }
            (_, Some(v), _) | (_, _, Default::Grey(v)) => Rgb::splat(v as f32),
            _ => unreachable!("{IN_TABLE}"),
        }
    }

    /// A colour or a texture.
    ///
    /// # Errors
    /// Those of the texture.
    pub(super) fn rgb_texture(&self, name: &str) -> Result<Textured<Rgb>, Issue> {
        Ok(match self.texture_object(name) {
            Some(texture) => Textured::Varying(self.within_bounds(name, &texture)?),
            None => Textured::Uniform(self.rgb(name)),
        })
    }

    /// A number or a texture. The mean stands for a colour, as in Mitsuba.
    ///
    /// # Errors
    /// Those of the texture.
    pub(super) fn float_texture(&self, name: &str) -> Result<Textured<f32>, Issue> {
        if let Some(texture) = self.texture_object(name) {
            return Ok(Textured::Varying(self.within_bounds(name, &texture)?));
        }
        Ok(Textured::Uniform(match self.value(name) {
            Some(Value::Rgb(_) | Value::Spectrum(_)) => self.rgb(name).element_sum() / 3.0,
            _ => self.float(name) as f32,
        }))
    }

    /// The texture that a property is.
    fn texture_object(&self, name: &str) -> Option<Self> {
        let named = self.node?.children.iter().filter(|c| c.name == name);
        let mut objects = named.filter_map(|c| Self::new(self.context, c.node));
        objects.find(|o| o.plugin.category() == Category::Texture)
    }

    /// The texture that this object describes.
    ///
    /// # Errors
    /// What is wrong with it or with its file.
    pub(super) fn texture(&self) -> Result<Arc<dyn Texture>, Issue> {
        let (Build::Texture(build), Some(index)) = (self.plugin.build, self.index) else {
            unreachable!("callers pass textures")
        };
        if let Some(texture) = lock(&self.context.textures).get(&index) {
            return Ok(Arc::clone(texture));
        }
        // Not under the lock: a texture may hold others.
        let texture = build(self)?;
        lock(&self.context.textures).insert(index, Arc::clone(&texture));
        Ok(texture)
    }

    /// The texture that a property is, with its values kept within what the property takes.
    fn within_bounds(&self, name: &str, texture: &Self) -> Result<Arc<dyn Texture>, Issue> {
        let built = texture.texture()?;
        let kind = self.plugin.property(name).expect(IN_TABLE).kind;
        let (Kind::RgbTexture(bounds) | Kind::FloatTexture(bounds)) = kind else {
            unreachable!("{IN_TABLE}")
        };
        let range @ [least, most] = built.range();
        if range.into_iter().all(|value| bounds.contain(value.into())) {
            return Ok(built);
        }
        let shown = |v: f32| if v.abs() < 1e6 { v.to_string() } else { format!("{v:e}") };
        let (from, to) = (shown(least), shown(most));
        let what =
            format!("`{name}` is a texture with values from {from} to {to} (expected: {kind})");
        let limits @ [lower, upper] = bounds.limits();
        if most < lower || upper < least {
            // As for a number.
            return Err(Issue::new(texture.place(), what));
        }
        let message = format!("{what}; the nearest value within takes the place of those outside");
        let help = "if the picture was enlarged or sharpened, clamp it afterwards";
        self.warn(Issue::new(texture.place(), message).with_help(help));
        let key = (texture.index.expect("a texture is in the graph"), bounds);
        let mut clamped = lock(&self.context.clamped_textures);
        Ok(Arc::clone(clamped.entry(key).or_insert_with(|| built.clamped(limits))))
    }

    /// Whether more than one object has it as its part.
    pub(super) fn is_shared(&self) -> bool {
        self.node.is_some_and(|node| node.owners > 1)
    }

    /// The material that this object describes, which `build` makes the first time.
    ///
    /// # Errors
    /// Those of `build`.
    pub(super) fn shared_material(
        &self,
        build: impl FnOnce(&Self) -> Result<Box<dyn Bsdf>, Issue>,
    ) -> Result<Arc<dyn Bsdf>, Issue> {
        let index = self.index.expect("what is shared is in the graph");
        if let Some(material) = lock(&self.context.materials).get(&index) {
            return Ok(Arc::clone(material));
        }
        let material = Arc::from(build(self)?);
        lock(&self.context.materials).insert(index, Arc::clone(&material));
        Ok(material)
    }

    /// The image in the file that a property names, decoded once however often it is named.
    ///
    /// # Errors
    /// No such file, or one that cannot be read.
    pub(super) fn image(&self, name: &str) -> Result<Arc<Image>, Issue> {
        let path = self.file(name)?;
        self.image_at(&path).map_err(|message| {
            Issue::new(self.place_of(name), format!("{} {message}", path.display()))
        })
    }

    /// The image in a file, decoded once however often it is asked for.
    ///
    /// # Errors
    /// What is wrong with the file: a fragment.
    pub(super) fn image_at(&self, path: &Path) -> Result<Arc<Image>, String> {
        let once = Arc::clone(lock(&self.context.images).entry(path.to_owned()).or_default());
        // Decoded outside of the lock; who comes second waits for this file alone.
        once.get_or_init(|| image::load(path, self.context.limits).map(Arc::new)).clone()
    }

    pub(super) fn refractive_index(&self, name: &str) -> f32 {
        let named = || self.text(name).and_then(indices::find);
        self.number(name).or_else(named).expect(IN_TABLE) as f32
    }

    /// The file that a property names.
    ///
    /// # Errors
    /// No such file. A comment right before the property is shown, or else the comment at the head of
    /// the scene if it mentions the file: either may say where the file comes from.
    pub(super) fn file(&self, name: &str) -> Result<PathBuf, Issue> {
        let text = self.text(name).expect(IN_TABLE);
        let place = self.place_of(name);
        self.context.sources.find_file(text, place).map_err(|issue| {
            let file_name = Path::new(text).file_name().and_then(|n| n.to_str()).unwrap_or(text);
            let opening = self.context.sources.get(place.file).opening.as_deref();
            let opening = opening.filter(|comment| comment.contains(file_name));
            match self.given(name).and_then(|p| p.comment.as_deref()).or(opening) {
                Some(comment) => issue.with_help(format!("the scene says: {comment}")),
                None => issue,
            }
        })
    }

    fn given(&self, name: &str) -> Option<&'a Property> {
        self.node?.properties.iter().find(|p| p.name == name)
    }

    fn value(&self, name: &str) -> Option<&'a Value> {
        self.given(name)?.value.as_ref()
    }

    fn default(&self, name: &str) -> Default {
        self.plugin.property(name).expect(IN_TABLE).default
    }
}
