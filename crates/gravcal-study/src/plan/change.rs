//! Changes of a TOML table: `torque.std`, `sweep.*.poses`, `load.0.mass_kg`.

use gravcal_session::document::Field;
use toml::{Table, Value};

/// One field, or every field that a pattern names, gets a value or goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Keys, indices counted from 0, or `*` for every element, with dots between.
    pub field: String,
    /// The value; `None` to take the field away.
    pub value: Option<Value>,
    /// Where the study says it.
    pub said: Field,
}

impl Change {
    /// Makes the change.
    ///
    /// # Errors
    /// Says which part of the field is not there. Tables that are missing on the way are made, elements of lists are not.
    pub fn make(&self, table: &mut Table) -> Result<(), String> {
        let keys: Vec<&str> = self.field.split('.').collect();
        if keys.iter().any(|key| key.is_empty()) {
            return Err(format!("`{}` is no field: expected keys with dots between, such as torque.std", self.field));
        }
        change_table(table, &keys, self.value.as_ref()).map_err(|why| format!("`{}`: {why}", self.field))
    }
}

fn change_table(table: &mut Table, keys: &[&str], value: Option<&Value>) -> Result<(), String> {
    let [key, rest @ ..] = keys else { return Ok(()) };
    match (rest, value) {
        ([], Some(value)) => drop(table.insert((*key).to_owned(), value.clone())),
        ([], None) => {
            table.remove(*key).ok_or_else(|| format!("there is no `{key}` to drop"))?;
        }
        (_, None) if !table.contains_key(*key) => return Err(format!("there is no `{key}`")),
        (_, _) => {
            let inner = table.entry((*key).to_owned()).or_insert_with(|| Value::Table(Table::new()));
            change_value(inner, key, rest, value)?;
        }
    }
    Ok(())
}

fn change_value(inner: &mut Value, name: &str, keys: &[&str], value: Option<&Value>) -> Result<(), String> {
    match inner {
        Value::Table(table) => change_table(table, keys, value),
        Value::Array(list) => change_list(list, name, keys, value),
        _ => Err(format!("`{name}` is neither a table nor a list")),
    }
}

fn change_list(list: &mut [Value], name: &str, keys: &[&str], value: Option<&Value>) -> Result<(), String> {
    let [key, rest @ ..] = keys else { return Ok(()) };
    let count = list.len();
    let chosen: &mut [Value] = match *key {
        "*" if count > 0 => list,
        "*" => return Err(format!("`{name}` is an empty list")),
        index => {
            let index: usize = index.parse().map_err(|_| {
                format!("`{name}` is a list: expected `*` for every element, or a number from 0, found `{index}`")
            })?;
            let element = list.get_mut(index..=index);
            element.ok_or_else(|| format!("`{name}` has {count} elements, counted from 0, and no {index}"))?
        }
    };
    for element in chosen {
        match (rest, value) {
            ([], Some(value)) => *element = value.clone(),
            ([], None) => return Err(format!("an element of `{name}` cannot be dropped: give the whole list")),
            (_, _) => change_value(element, name, rest, value)?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(field: &str, value: Option<Value>) -> Result<String, String> {
        let mut table: Table =
            toml::from_str("[torque]\nstd = 0.8\n[[sweep]]\nposes = 3\n[[sweep]]\nposes = 4\n").unwrap();
        Change { field: field.to_owned(), value, said: Field::new("change") }.make(&mut table)?;
        Ok(toml::to_string(&table).unwrap())
    }

    #[test]
    fn fields_elements_and_all_elements_are_changed() {
        let std = changed("torque.std", Some(Value::from(2.0))).unwrap();
        assert!(std.contains("std = 2.0"));
        let every = changed("sweep.*.poses", Some(Value::from(7))).unwrap();
        assert_eq!(every.matches("poses = 7").count(), 2);
        let one = changed("sweep.1.poses", Some(Value::from(7))).unwrap();
        assert!(one.contains("poses = 3") && one.contains("poses = 7"));
    }

    #[test]
    fn missing_tables_are_made_and_fields_dropped() {
        let made = changed("session.loss.kind", Some(Value::from("huber"))).unwrap();
        assert!(made.contains("[session.loss]\nkind = \"huber\""));
        assert!(!changed("torque.std", None).unwrap().contains("std"));
    }

    #[test]
    fn what_is_not_there_is_named() {
        let refused = |field: &str, value| changed(field, value).unwrap_err();
        let one = || Some(Value::from(1));
        assert_eq!(refused("torque.converter", None), "`torque.converter`: there is no `converter` to drop");
        assert_eq!(refused("load.0", None), "`load.0`: there is no `load`");
        assert_eq!(refused("torque.std.x", one()), "`torque.std.x`: `std` is neither a table nor a list");
        assert_eq!(
            refused("sweep.2.poses", one()),
            "`sweep.2.poses`: `sweep` has 2 elements, counted from 0, and no 2"
        );
        assert!(refused("sweep.poses", one()).contains("expected `*` for every element"));
        assert!(refused("torque..std", one()).contains("is no field"));
    }
}
