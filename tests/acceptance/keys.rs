//! The keys of a file, as the structs say that read or write it: their names, types, defaults and documentation.
//!
//! A key's documentation is its meaning, and then lines of their own: `Unit: …`, `Default: …`, `Example: …`. What its name or its
//! type says need not stand there.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};

use gravcal_robot_model::EstimatorName;
use serde_json::{Value, json};
use syn::{Attribute, Expr, Fields, GenericArgument, Ident, Item, Lit, Meta, PathArguments, Type};

use crate::tree;

/// Structs and enums of some folders.
pub struct Sources(BTreeMap<(PathBuf, String), Item>);

/// A table of a file, with its keys.
pub struct Table {
    /// How its header is written, such as `[readings.position]`; empty at the top of the file.
    pub header: String,
    /// What it is.
    pub documentation: String,
    /// Its keys, in the order in which they are declared.
    pub keys: Vec<Key>,
    /// How other tables of the file refer to it.
    pub id: String,
    /// Whether it refuses all other keys.
    pub closed: bool,
}

/// What may stand at one key.
#[derive(Default)]
pub struct Key {
    pub name: String,
    /// In words; a link where it is a table of its own.
    pub kind: String,
    pub unit: String,
    /// What holds where the key is absent.
    pub default: String,
    pub meaning: String,
    pub example: String,
    /// What may stand there, as JSON Schema says it; other tables by [`reference`].
    pub schema: Value,
    pub required: bool,
}

/// What one type comes to: words, and the struct of a table if it is one.
struct Kind {
    words: String,
    table: Option<(PathBuf, String)>,
    many: bool,
    schema: Value,
}

/// Types that are read by hand, in words and as a schema.
fn by_hand(name: &str) -> Option<(&'static str, Value)> {
    let text = || json!({ "type": "string" });
    let numbers = || json!({ "type": "object", "additionalProperties": { "type": "number" } });
    Some(match name {
        "RobotSource" => {
            let tip = json!({ "anyOf": [text(), { "type": "array", "items": text() }] });
            let properties = json!({ "urdf": text(), "base": text(), "tip": tip });
            let urdf = json!({
                "type": "object", "properties": properties, "required": ["urdf", "base", "tip"], "additionalProperties": false
            });
            ("text, or a table of `urdf`, `base` and `tip`", json!({ "anyOf": [text(), urdf] }))
        }
        "OneOrNamed" => {
            ("number, or a table of numbers by name", json!({ "anyOf": [{ "type": "number" }, numbers()] }))
        }
        "Written" => ("text, or a table with `name` and options", json!({ "anyOf": [text(), named("name")] })),
        "WrittenMass" => {
            let mass = || json!({ "type": "number", "minimum": 0 });
            let weighed = json!({
                "type": "object", "properties": { "nominal": mass(), "std": mass() }, "required": ["nominal", "std"],
                "additionalProperties": false
            });
            let schema = json!({ "anyOf": [mass(), weighed, { "enum": ["unknown"] }] });
            ("number, a table of `nominal` and `std`, or `\"unknown\"`", schema)
        }
        "unexplained::Written" => {
            let words = json!({ "enum": ["estimated", "none"] });
            ("number or text", json!({ "anyOf": [{ "type": "number", "minimum": 0 }, words] }))
        }
        "RotorInertia" => {
            let number = || json!({ "type": "number" });
            let properties = json!({ "nominal": number(), "std": number(), "fixed": number(), "unit": text() });
            let table = json!({
                "type": "object", "properties": properties, "required": ["unit"], "additionalProperties": false
            });
            let words = json!({ "enum": ["unknown"] });
            ("`\"unknown\"`, or a table of `nominal`, `std`, `fixed` and `unit`", json!({ "anyOf": [words, table] }))
        }
        "ModelTable" => ("table: see [Sensor models](sensor-models.md)", named("kind")),
        "Value" => ("any value", json!({})),
        "Table" => ("table", json!({ "type": "object" })),
        "EstimatorName" => ("text", json!({ "enum": EstimatorName::ALL.map(EstimatorName::as_str) })),
        "String" | "PathBuf" | "str" => ("text", text()),
        "bool" => ("true or false", json!({ "type": "boolean" })),
        _ => return None,
    })
}

/// A table of which one key is known, a text.
fn named(key: &str) -> Value {
    json!({ "type": "object", "properties": { key: { "type": "string" } }, "required": [key] })
}

/// How a schema refers to a table.
pub fn reference(id: &str) -> Value {
    json!({ "$ref": format!("#/definitions/{id}") })
}

impl Sources {
    /// Those of some folders of the project, tests aside.
    pub fn of(folders: &[&str]) -> Sources {
        let files = folders.iter().flat_map(|folder| tree::files_below(&tree::root().join(folder)));
        let mut found = BTreeMap::new();
        for file in files.filter(|file| file.extension().is_some_and(|extension| extension == "rs")) {
            let parsed = syn::parse_file(&fs::read_to_string(&file).unwrap()).unwrap();
            for item in parsed.items {
                let name = match &item {
                    Item::Struct(item) => item.ident.to_string(),
                    Item::Enum(item) => item.ident.to_string(),
                    _ => continue,
                };
                found.insert((file.clone(), name), item);
            }
        }
        Sources(found)
    }

    /// The tables of a file whose top is a struct of one source.
    pub fn tables(&self, file: &str, root: &str) -> Vec<Table> {
        let root = (tree::root().join(file), root.to_owned());
        assert!(self.0.contains_key(&root), "{root:?}");
        let (mut tables, mut headers) = (Vec::new(), BTreeMap::from([(root.clone(), String::new())]));
        let mut open = VecDeque::from([root]);
        let mut seen = BTreeSet::new();
        while let Some(at) = open.pop_front() {
            if !seen.insert(at.clone()) {
                continue;
            }
            let header = headers[&at].clone();
            let mut keys = Vec::new();
            for (key, kind) in self.keys(&at) {
                let mut key = key;
                if let Some(table) = kind.table {
                    let inside = header.trim_matches(['[', ']']);
                    let path = if inside.is_empty() { key.name.clone() } else { format!("{inside}.{}", key.name) };
                    let brackets = if kind.many { ("[[", "]]") } else { ("[", "]") };
                    let own = headers.entry(table.clone()).or_insert(format!("{}{path}{}", brackets.0, brackets.1));
                    key.kind = format!("[{}](#{})", kind.words, anchor(own));
                    open.push_back(table);
                }
                keys.push(key);
            }
            let attributes = attributes(&self.0[&at]);
            let closed = serde(attributes).iter().any(|word| word == "deny_unknown_fields");
            tables.push(Table {
                header,
                documentation: documentation(attributes).join(" "),
                keys,
                id: id(&at),
                closed,
            });
        }
        tables
    }

    /// The keys of a struct, with what each may hold; those of a flattened field among them.
    fn keys(&self, at: &(PathBuf, String)) -> Vec<(Key, Kind)> {
        let all_default = serde(attributes(&self.0[at])).iter().any(|word| word == "default");
        let mut keys: Vec<(Key, Kind)> = Vec::new();
        if let Item::Enum(item) = &self.0[at] {
            let name = tag(item).unwrap_or_else(|| panic!("{at:?} has no tag"));
            let schema = json!({ "enum": spellings(item) });
            let (kind, meaning) = (choices(item), "Which one.".to_owned());
            let key = Key { name, kind, meaning, schema: schema.clone(), required: true, ..Key::default() };
            keys.push((key, plain(choices(item), schema)));
        }
        for field in fields(&self.0[at]) {
            let name = field.ident.as_ref().unwrap().to_string();
            let said = serde(&field.attrs);
            if said.iter().any(|word| word == "skip") || name.starts_with('_') {
                continue;
            }
            let kind = self.kind(&at.0, &field.ty);
            if said.iter().any(|word| word == "flatten") {
                keys.extend(kind.table.iter().flat_map(|table| self.keys(table)));
                continue;
            }
            let renamed = said.iter().find_map(|word| word.strip_prefix("rename = "));
            let mut key = Key { name: renamed.map_or(name, |new| new.trim_matches('"').to_owned()), ..Key::default() };
            key.kind.clone_from(&kind.words);
            let optional = is_option(&field.ty) || all_default || said.iter().any(|word| word.starts_with("default"));
            describe(&mut key, &documentation(&field.attrs), optional);
            key.schema.clone_from(&kind.schema);
            // Of several variants none has the keys of the others, and a number that is undetermined is written as null.
            let left_out = said.iter().any(|word| word.starts_with("skip_serializing_if"));
            key.required = !optional && !left_out && matches!(self.0[at], Item::Struct(_));
            if is_option(&field.ty) && is_written(&self.0[at]) {
                key.schema = json!({ "anyOf": [key.schema, { "type": "null" }] });
            }
            if keys.iter().all(|(other, _)| other.name != key.name) {
                keys.push((key, kind));
            }
        }
        keys
    }

    fn kind(&self, file: &Path, kind: &Type) -> Kind {
        match kind {
            Type::Reference(reference) => self.kind(file, &reference.elem),
            Type::Slice(slice) => self.list(file, &slice.elem),
            Type::Array(array) => {
                let Expr::Lit(length) = &array.len else { panic!("an array without a length") };
                let Lit::Int(length) = &length.lit else { panic!("an array without a length") };
                let Kind { words, schema, .. } = self.kind(file, &array.elem);
                let count: usize = length.base10_parse().unwrap();
                let schema = json!({ "type": "array", "items": schema, "minItems": count, "maxItems": count });
                plain(format!("{length} × {words}"), schema)
            }
            Type::Tuple(tuple) => {
                let parts: Vec<Kind> = tuple.elems.iter().map(|part| self.kind(file, part)).collect();
                let words: Vec<&str> = parts.iter().map(|part| part.words.as_str()).collect();
                let words = format!("list of {}", words.join(" and "));
                let (count, any) = (parts.len(), parts.into_iter().map(|part| part.schema).collect::<Vec<_>>());
                let schema =
                    json!({ "type": "array", "items": { "anyOf": any }, "minItems": count, "maxItems": count });
                plain(words, schema)
            }
            Type::Path(path) => self.named(file, path),
            _ => panic!("a type that no file holds"),
        }
    }

    fn named(&self, file: &Path, path: &syn::TypePath) -> Kind {
        let segments: Vec<&Ident> = path.path.segments.iter().map(|segment| &segment.ident).collect();
        let name = segments.last().unwrap().to_string();
        let full = segments.iter().map(ToString::to_string).collect::<Vec<_>>().join("::");
        let inside = |index: usize| argument(path, index);
        match name.as_str() {
            "f64" | "f32" => return plain("number".to_owned(), json!({ "type": "number" })),
            "i32" | "i64" => return plain("whole number".to_owned(), json!({ "type": "integer" })),
            "usize" | "u8" | "u16" | "u32" | "u64" => {
                return plain("whole number".to_owned(), json!({ "type": "integer", "minimum": 0 }));
            }
            "Option" | "Cow" => return self.kind(file, inside(0)),
            "Vec" => return self.list(file, inside(0)),
            "OneOrMany" => {
                let Kind { words, schema, .. } = self.kind(file, inside(0));
                let schema = json!({ "anyOf": [schema, { "type": "array", "items": schema }] });
                return plain(format!("{words}, or a list"), schema);
            }
            "BTreeMap" => {
                let Kind { words, table, schema, .. } = self.kind(file, inside(1));
                let schema = json!({ "type": "object", "additionalProperties": schema });
                return Kind { words: format!("table: {words} by name"), table, many: false, schema };
            }
            _ => {}
        }
        if let Some((words, schema)) = by_hand(&full).or_else(|| by_hand(&name)) {
            return plain(words.to_owned(), schema);
        }
        let module = segments.len().checked_sub(2).map(|at| segments[at].to_string());
        let found = self.find(file, module.as_deref(), &name);
        match &self.0[&found] {
            Item::Enum(item) if tag(item).is_none() => plain(choices(item), json!({ "enum": spellings(item) })),
            _ => {
                let schema = reference(&id(&found));
                Kind { words: "table".to_owned(), table: Some(found), many: false, schema }
            }
        }
    }

    fn list(&self, file: &Path, of: &Type) -> Kind {
        let Kind { words, table, schema, .. } = self.kind(file, of);
        let words = if words.contains([' ', ':']) { format!("list of: {words}") } else { format!("list of {words}s") };
        Kind { words, table, many: true, schema: json!({ "type": "array", "items": schema }) }
    }

    /// The one that a name means in a file: its own, that of the module it names, or the nearest.
    fn find(&self, file: &Path, module: Option<&str>, name: &str) -> (PathBuf, String) {
        let of_name = || self.0.keys().filter(|(_, other)| other == name);
        let own = of_name().find(|(at, _)| at == file);
        let of_module = || of_name().find(|(at, _)| module.is_some_and(|module| at.file_stem().unwrap() == module));
        let near = || {
            let shared = |at: &Path| at.components().zip(file.components()).take_while(|(a, b)| a == b).count();
            of_name().max_by_key(|(at, _)| shared(at))
        };
        let found = own.or_else(of_module).or_else(near);
        found.unwrap_or_else(|| panic!("{}: {name} is not among the sources", file.display())).clone()
    }
}

fn plain(words: String, schema: Value) -> Kind {
    Kind { words, table: None, many: false, schema }
}

/// A name for a struct that no other has: that of its file stands before it.
fn id((file, name): &(PathBuf, String)) -> String {
    let stem = file.file_stem().unwrap().to_string_lossy();
    let folder = file.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
    let module = if stem == "mod" { folder } else { stem };
    format!("{module}.{name}")
}

/// Whether a type is written and not read.
fn is_written(item: &Item) -> bool {
    let derives = attributes(item).iter().filter(|attribute| attribute.path().is_ident("derive"));
    let mut words = derives.filter_map(|attribute| match &attribute.meta {
        Meta::List(list) => Some(list.tokens.to_string()),
        _ => None,
    });
    words.any(|words| words.split(',').any(|word| word.trim() == "Serialize"))
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Struct(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        _ => &[],
    }
}

/// The fields of a struct, or of all variants of an enum.
fn fields(item: &Item) -> Vec<&syn::Field> {
    let named = |fields: &'_ Fields| matches!(fields, Fields::Named(_));
    match item {
        Item::Struct(item) if named(&item.fields) => item.fields.iter().collect(),
        Item::Enum(item) => {
            item.variants.iter().filter(|variant| named(&variant.fields)).flat_map(|variant| &variant.fields).collect()
        }
        _ => panic!("neither a struct nor an enum with names"),
    }
}

/// The key that says which variant of an enum a table is.
fn tag(item: &syn::ItemEnum) -> Option<String> {
    serde(&item.attrs).iter().find_map(|word| word.strip_prefix("tag = ")).map(|tag| tag.trim_matches('"').to_owned())
}

fn is_option(kind: &Type) -> bool {
    matches!(kind, Type::Path(path) if path.path.segments.last().unwrap().ident == "Option")
}

fn argument(path: &syn::TypePath, index: usize) -> &Type {
    let PathArguments::AngleBracketed(arguments) = &path.path.segments.last().unwrap().arguments else {
        panic!("a type without arguments")
    };
    let mut types = arguments.args.iter().filter_map(|argument| match argument {
        GenericArgument::Type(kind) => Some(kind),
        _ => None,
    });
    types.nth(index).unwrap()
}

/// What serde is told of a field or a type, word by word.
fn serde(attributes: &[Attribute]) -> Vec<String> {
    let lists = attributes.iter().filter(|attribute| attribute.path().is_ident("serde"));
    let words = lists.filter_map(|attribute| match &attribute.meta {
        Meta::List(list) => Some(list.tokens.to_string()),
        _ => None,
    });
    words.flat_map(|words| words.split(',').map(|word| word.trim().to_owned()).collect::<Vec<_>>()).collect()
}

/// The lines of a documentation.
fn documentation(attributes: &[Attribute]) -> Vec<String> {
    let said = attributes.iter().filter(|attribute| attribute.path().is_ident("doc"));
    let lines = said.filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) => match &pair.value {
            Expr::Lit(text) => match &text.lit {
                Lit::Str(text) => Some(text.value().trim().to_owned()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    });
    lines.map(|line| without_code_links(&line)).collect()
}

/// A line without the targets of links that only rustdoc can follow.
fn without_code_links(line: &str) -> String {
    let own = line.replace("](gravcal_", "](crate::");
    let mut parts = own.split("](crate::");
    let first = parts.next().unwrap_or_default().to_owned();
    let (text, linked) = parts.fold((first, false), |(text, _), part| {
        let rest = part.split_once(')').map_or("", |(_, rest)| rest);
        let opening = text.rfind('[').unwrap_or(text.len());
        (format!("{}{}{rest}", &text[..opening], text.get(opening + 1..).unwrap_or_default()), true)
    });
    if linked { text } else { line.to_owned() }
}

/// The texts that an enum may be written as, in words.
fn choices(item: &syn::ItemEnum) -> String {
    spellings(item).iter().map(|name| format!("`\"{name}\"`")).collect::<Vec<_>>().join(" or ")
}

fn spellings(item: &syn::ItemEnum) -> Vec<String> {
    let rule = serde(&item.attrs);
    let rule = rule.iter().find_map(|word| word.strip_prefix("rename_all = ")).map(|rule| rule.trim_matches('"'));
    let names = item.variants.iter().map(|variant| {
        let own = serde(&variant.attrs);
        let own =
            own.iter().find_map(|word| word.strip_prefix("rename = ")).map(|name| name.trim_matches('"').to_owned());
        own.unwrap_or_else(|| cased(&variant.ident.to_string(), rule))
    });
    names.collect()
}

fn cased(name: &str, rule: Option<&str>) -> String {
    let separator = match rule {
        Some("lowercase") => return name.to_lowercase(),
        Some("kebab-case") => '-',
        Some("snake_case") => '_',
        _ => return name.to_owned(),
    };
    let mut written = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !written.is_empty() {
            written.push(separator);
        }
        written.extend(letter.to_lowercase());
    }
    written
}

/// Ends of names that say a unit, longest first.
const UNITS: [(&str, &str); 21] = [
    ("_rad_per_newton_metre", "rad/(N·m)"),
    ("_rad_or_m_per_s", "rad/s or m/s"),
    ("_newton_metre", "N·m"),
    ("_rad_per_s2", "rad/s²"),
    ("_m_per_s2", "m/s²"),
    ("_per_root_s", "per √s"),
    ("_kg_m", "kg·m"),
    ("_degC", "degC"),
    ("_deg", "deg"),
    ("_rad", "rad"),
    ("_kg", "kg"),
    ("_hz", "Hz"),
    ("_s", "s"),
    ("_m", "m"),
    ("_si", "SI"),
    ("p_value", "1"),
    ("bytes", "byte"),
    ("iterations", "1"),
    ("chi_squared", "1"),
    ("degrees_of_freedom", "1"),
    ("cosine", "1"),
];

/// Fills in what the documentation says.
fn describe(key: &mut Key, documentation: &[String], optional: bool) {
    let mut meaning: Vec<&str> = Vec::new();
    let mut about = ("meaning", String::new());
    let mut said: BTreeMap<&str, String> = BTreeMap::new();
    for line in documentation {
        let label = ["Unit", "Default", "Example"].into_iter().find(|label| line.starts_with(&format!("{label}: ")));
        match label {
            Some(label) => {
                about = (label, String::new());
                said.insert(label, line[label.len() + 2..].to_owned());
            }
            None if about.0 == "meaning" => meaning.push(line),
            None => said.entry(about.0).or_default().push_str(&format!(" {line}")),
        }
    }
    key.meaning = meaning.join(" ").trim().to_owned();
    let sentence = |label: &str| said.get(label).map(|text| text.trim().trim_end_matches('.').to_owned());
    let number = key.kind.contains("number");
    let by_name = UNITS.iter().find(|(end, _)| number && key.name.ends_with(end)).map(|(_, unit)| (*unit).to_owned());
    key.unit = sentence("Unit").or(by_name).unwrap_or_default();
    key.default = sentence("Default").unwrap_or_else(|| if optional { "–".to_owned() } else { "required".to_owned() });
    key.example = said.get("Example").cloned().unwrap_or_default();
}

/// How a header is linked to.
pub fn anchor(header: &str) -> String {
    header.to_lowercase().chars().filter(|letter| letter.is_alphanumeric() || matches!(letter, '_' | '-')).collect()
}
