//! Which files of a crate import which.
//!
//! An import is a path in the code, of a `use` or of anything else, and leads to the file that defines what it names: a facade's
//! re-exports are followed. To name a module is no import, only to name what is in it. Tests import what they like.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{Visit, visit_item, visit_macro, visit_meta_list, visit_path};
use syn::{Attribute, Ident, Item, ItemMod, ItemUse, Macro, Meta, MetaList, UseTree};

/// The files of a crate, each with those that it imports and the names from there.
pub struct Imports(BTreeMap<PathBuf, BTreeMap<PathBuf, BTreeSet<String>>>);

impl Imports {
    /// Those of the library or program whose first file is `root`.
    pub fn of(root: &Path) -> Imports {
        let modules = Modules::of(root);
        let mut imports: BTreeMap<PathBuf, BTreeMap<PathBuf, BTreeSet<String>>> = BTreeMap::new();
        for (at, module) in &modules.0 {
            let from = imports.entry(module.file.clone()).or_default();
            let defined = module.paths.iter().filter_map(|path| modules.definition(at, path));
            for (file, name) in defined.filter(|(file, _)| *file != module.file) {
                from.entry(file).or_default().insert(name);
            }
        }
        Imports(imports)
    }

    /// Files that import each other, directly or through others of them: the strongly connected components, largest first.
    pub fn circles(&self) -> Vec<Vec<&Path>> {
        let reached: BTreeMap<&Path, BTreeSet<&Path>> =
            self.0.keys().map(|file| (file.as_path(), self.reached_from(file))).collect();
        let mut circles: BTreeSet<Vec<&Path>> = BTreeSet::new();
        for (file, others) in reached.iter().filter(|(file, others)| others.contains(*file)) {
            circles.insert(others.iter().copied().filter(|other| reached[other].contains(file)).collect());
        }
        let mut circles: Vec<_> = circles.into_iter().collect();
        circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
        circles
    }

    /// What files import that the facade of their own folder defines, a line each, for messages.
    pub fn taken_from_own_facade(&self) -> String {
        let mut reported = String::new();
        for (file, imported) in &self.0 {
            let own = facades_over(file);
            for (facade, names) in imported.iter().filter(|(imported, _)| own.contains(imported)) {
                reported += &format!("{} imports {names:?} from {}\n", file.display(), facade.display());
            }
        }
        reported
    }

    fn reached_from<'a>(&'a self, file: &'a Path) -> BTreeSet<&'a Path> {
        let (mut reached, mut open) = (BTreeSet::new(), vec![file]);
        while let Some(file) = open.pop() {
            open.extend(self.0[file].keys().map(PathBuf::as_path).filter(|imported| reached.insert(*imported)));
        }
        reached
    }

    /// What the files of a circle import from each other, a line each, for messages.
    pub fn within(&self, circle: &[&Path]) -> String {
        let mut reported = String::new();
        for file in circle {
            for (imported, names) in self.0[*file].iter().filter(|(imported, _)| circle.contains(&imported.as_path())) {
                reported += &format!("{} imports {names:?} from {}\n", file.display(), imported.display());
            }
        }
        reported
    }
}

/// Where the module over that of a file may stand.
fn facades_over(file: &Path) -> [PathBuf; 3] {
    let beside = file.parent().unwrap();
    let folder = if file.ends_with("mod.rs") { beside.parent().unwrap() } else { beside };
    [folder.join("mod.rs"), folder.join("lib.rs"), folder.with_extension("rs")]
}

/// A path in its parts.
type Names = Vec<String>;

/// What the code of a module names.
#[derive(Default)]
struct Module {
    file: PathBuf,
    /// What `use` brings into the module, by the name that it has here.
    used: BTreeMap<String, Names>,
    paths: BTreeSet<Names>,
}

/// Modules by their path from the root.
#[derive(Default)]
struct Modules(BTreeMap<Names, Module>);

impl Modules {
    fn of(root: &Path) -> Modules {
        let mut modules = Modules::default();
        modules.read(Names::new(), root, root.parent().unwrap());
        modules
    }

    /// Reads the module of a file, and those below it, which lie in `folder`.
    fn read(&mut self, at: Names, file: &Path, folder: &Path) {
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let parsed = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        self.add(at, file, folder, &parsed.items);
    }

    fn add(&mut self, at: Names, file: &Path, folder: &Path, items: &[Item]) {
        let mut reader = Reader(Module { file: file.to_owned(), ..Module::default() });
        items.iter().for_each(|item| reader.visit_item(item));
        self.0.insert(at.clone(), reader.0);
        for module in items.iter().filter_map(module_of_program) {
            let (below, folder) = (with(&at, &module.ident), folder.join(module.ident.to_string()));
            match &module.content {
                Some((_, items)) => self.add(below, file, &folder, items),
                None => {
                    let beside = folder.with_extension("rs");
                    let file = if beside.exists() { beside } else { folder.join("mod.rs") };
                    self.read(below, &file, &folder);
                }
            }
        }
    }

    /// The file that defines what a path in a module names, and its name there. Nothing of what other crates define, and of modules.
    fn definition(&self, at: &[String], path: &[String]) -> Option<(PathBuf, String)> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.definition_below(&[], rest),
            "self" => self.definition_below(at, rest),
            "super" => self.definition_below(&at[..at.len() - 1], rest),
            name if self.0[at].used.contains_key(name) || self.0.contains_key(&below(at, name)) => {
                self.definition_below(at, path)
            }
            _ => None,
        }
    }

    /// The same of a path that begins in a module of this crate.
    fn definition_below(&self, at: &[String], path: &[String]) -> Option<(PathBuf, String)> {
        let (first, rest) = path.split_first()?;
        let (module, inner) = (&self.0[at], below(at, first));
        match module.used.get(first) {
            _ if first == "super" => self.definition(at, path),
            // A module may share its name with a function.
            _ if !rest.is_empty() && self.0.contains_key(&inner) => self.definition_below(&inner, rest),
            Some(used) if used[0] != *first => self.definition(at, &[used, rest].concat()),
            _ if self.0.contains_key(&inner) => None,
            _ => Some((module.file.clone(), first.clone())),
        }
    }
}

fn below(at: &[String], name: &str) -> Names {
    [at, &[name.to_owned()]].concat()
}

fn with(before: &[String], name: &Ident) -> Names {
    below(before, &name.to_string())
}

fn module_of_program(item: &Item) -> Option<&ItemMod> {
    match item {
        Item::Mod(module) if !of_tests(&module.attrs) => Some(module),
        _ => None,
    }
}

/// Whether an item is compiled for tests only.
fn of_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) => list.path.is_ident("cfg") && words(&list.tokens.to_string()).any(|word| word == ["test"]),
        _ => false,
    })
}

/// The words of code that is not parsed, a path being one word in parts.
fn words(code: &str) -> impl Iterator<Item = Names> {
    let code = code.replace(" :: ", "::");
    let words: Vec<Names> = code
        .split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':')
        .map(|word| word.split("::").map(str::to_owned).collect())
        .collect();
    words.into_iter()
}

/// Reads the items of one module.
struct Reader(Module);

impl Reader {
    fn add(&mut self, tree: &UseTree, before: &[String]) {
        match tree {
            UseTree::Path(path) => self.add(&path.tree, &with(before, &path.ident)),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.add(tree, before)),
            UseTree::Name(name) if name.ident == "self" => {
                self.add_used(before.last().unwrap().clone(), before.to_vec())
            }
            UseTree::Name(name) => self.add_used(name.ident.to_string(), with(before, &name.ident)),
            UseTree::Rename(name) => self.add_used(name.rename.to_string(), with(before, &name.ident)),
            UseTree::Glob(_) => self.add_used("*".to_owned(), below(before, "*")),
        }
    }

    fn add_used(&mut self, name: String, path: Names) {
        self.0.paths.insert(path.clone());
        self.0.used.insert(name, path);
    }
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast Item) {
        let skipped = match item {
            Item::Mod(_) => true, // read for itself
            Item::Fn(function) => of_tests(&function.attrs),
            Item::Impl(block) => of_tests(&block.attrs),
            Item::Use(import) => of_tests(&import.attrs),
            _ => false,
        };
        if !skipped {
            visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, import: &'ast ItemUse) {
        self.add(&import.tree, &[]);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.0.paths.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit_path(self, path);
    }

    fn visit_macro(&mut self, code: &'ast Macro) {
        self.0.paths.extend(words(&code.tokens.to_string()));
        visit_macro(self, code);
    }

    fn visit_meta_list(&mut self, list: &'ast MetaList) {
        self.0.paths.extend(words(&list.tokens.to_string()));
        visit_meta_list(self, list);
    }
}

/// Writes a crate, and reads its imports.
fn written(folder: &Path, files: &[(&str, &str)]) -> Imports {
    for (name, text) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    Imports::of(&folder.join("lib.rs"))
}

/// The circles of the files of a crate.
fn circles(files: &[(&str, &str)]) -> Vec<Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    let imports = written(folder.path(), files);
    let name = |file: &&Path| file.strip_prefix(folder.path()).unwrap().to_string_lossy().replace('\\', "/");
    imports.circles().iter().map(|circle| circle.iter().map(name).collect()).collect()
}

#[test]
fn a_facade_that_defines_what_its_files_import_is_reported() {
    let reported = |facade: &str, size: &str| {
        let folder = tempfile::tempdir().unwrap();
        let files = [
            ("lib.rs", "mod parts;"),
            ("parts/mod.rs", facade),
            ("parts/one.rs", "use super::Size;"),
            ("parts/size.rs", size),
        ];
        written(folder.path(), &files).taken_from_own_facade()
    };
    assert!(reported("mod one; mod size; pub struct Size;", "").contains("imports {\"Size\"}"));
    assert_eq!(reported("mod one; mod size; pub use size::Size;", "pub struct Size;"), "");
}

#[test]
fn what_a_facade_re_exports_is_imported_from_where_it_stands() {
    let facade = ("parts/mod.rs", "mod one; mod two; pub use one::One; pub use two::{Two as Other};");
    let one = ("parts/one.rs", "use super::Other; pub struct One(Other);");
    let root = ("lib.rs", "mod parts; pub use parts::One;");
    assert!(circles(&[root, facade, one, ("parts/two.rs", "pub struct Two;")]).is_empty());
    let two = ("parts/two.rs", "pub struct Two; fn f() { let _ = vec![crate::One::default()]; }");
    assert_eq!(circles(&[root, facade, one, two]), [["parts/one.rs", "parts/two.rs"]]);
}

#[test]
fn a_file_imports_the_facade_for_what_that_defines() {
    let files = |facade: &str| {
        circles(&[
            ("lib.rs", "mod parts;"),
            ("parts.rs", facade),
            ("parts/one.rs", "pub mod deep;"),
            ("parts/one/deep.rs", "use super::super::Size; pub fn one(_: Size) {}"),
            ("parts/two.rs", "pub fn two() {}"),
        ])
    };
    let own = "mod one; mod two; pub struct Size; fn f() { one::deep::one(Size) }";
    assert_eq!(files(own), [["parts/one/deep.rs", "parts.rs"]]);
    assert!(files("mod one; mod two; pub struct Size; use two::two;").is_empty());
}

#[test]
fn tests_import_what_they_like() {
    let below =
        "pub struct Below; #[cfg(test)] use crate::above::Above; #[cfg(test)] mod tests { use crate::above::Above; }";
    let files = |below| {
        circles(&[
            ("lib.rs", "mod above; mod below;"),
            ("above.rs", "use crate::below::Below; pub struct Above;"),
            ("below.rs", below),
        ])
    };
    assert!(files(below).is_empty());
    assert_eq!(files(&below.replace("#[cfg(test)] ", "")), [["above.rs", "below.rs"]]);
}
