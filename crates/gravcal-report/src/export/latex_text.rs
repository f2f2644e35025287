//! Names and units as LaTeX sets them, with no package but those of its kernel.

/// Greek letters that are not those of the Latin alphabet, as commands of mathematical mode.
const GREEK: [(char, &str); 35] = [
    ('α', "alpha"),
    ('β', "beta"),
    ('γ', "gamma"),
    ('δ', "delta"),
    ('ε', "varepsilon"),
    ('ζ', "zeta"),
    ('η', "eta"),
    ('θ', "theta"),
    ('ι', "iota"),
    ('κ', "kappa"),
    ('λ', "lambda"),
    ('μ', "mu"),
    ('µ', "mu"),
    ('ν', "nu"),
    ('ξ', "xi"),
    ('π', "pi"),
    ('ρ', "rho"),
    ('σ', "sigma"),
    ('ς', "varsigma"),
    ('τ', "tau"),
    ('υ', "upsilon"),
    ('φ', "varphi"),
    ('χ', "chi"),
    ('ψ', "psi"),
    ('ω', "omega"),
    ('Γ', "Gamma"),
    ('Δ', "Delta"),
    ('Θ', "Theta"),
    ('Λ', "Lambda"),
    ('Ξ', "Xi"),
    ('Π', "Pi"),
    ('Σ', "Sigma"),
    ('Φ', "Phi"),
    ('Ψ', "Psi"),
    ('Ω', "Omega"),
];

/// A name, character by character.
pub(super) fn name(text: &str) -> String {
    let mut set = String::new();
    let mut before = None;
    for c in text.chars() {
        // Hyphens in a row would become a dash.
        if (before, c) == (Some('-'), '-') {
            set += "{}";
        }
        set += &character(c);
        before = Some(c);
    }
    set
}

/// A unit, whose `^2` is a power.
pub(super) fn unit(text: &str) -> String {
    let mut parts = text.split('^');
    let first = parts.next().map_or_else(String::new, name);
    parts.fold(first, |set, part| {
        let sign = usize::from(part.starts_with('-'));
        let digits = part[sign..].bytes().take_while(u8::is_ascii_digit).count();
        let (power, rest) = part.split_at(if digits == 0 { 0 } else { sign + digits });
        let power = match power.len() {
            0 => name("^"),
            1 => format!("$^{power}$"),
            _ => format!("$^{{{power}}}$"),
        };
        set + &power + &name(rest)
    })
}

fn character(c: char) -> String {
    if let Some((_, command)) = GREEK.iter().find(|(letter, _)| *letter == c) {
        return format!("$\\{command}$");
    }
    match c {
        '\\' => "\\textbackslash{}".to_owned(),
        '_' | '&' | '%' | '$' | '#' | '{' | '}' => format!("\\{c}"),
        '~' | '^' => format!("\\{c}{{}}"),
        '<' => "\\textless{}".to_owned(),
        '>' => "\\textgreater{}".to_owned(),
        '|' => "\\textbar{}".to_owned(),
        '`' => "\\textasciigrave{}".to_owned(),
        // Other fonts of the default encoding have no straight quotation mark.
        '"' => "{\\ttfamily\\char34}".to_owned(),
        '·' => "$\\cdot$".to_owned(),
        '°' => "$^\\circ$".to_owned(),
        '²' => "$^2$".to_owned(),
        '³' => "$^3$".to_owned(),
        'ο' => "o".to_owned(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_what_they_are() {
        assert_eq!(name("wrist_2"), "wrist\\_2");
        assert_eq!(name("a---b-c"), "a-{}-{}-b-c");
        assert_eq!(
            name("x^2~<\"|>α·Ω"),
            "x\\^{}2\\~{}\\textless{}{\\ttfamily\\char34}\\textbar{}\\textgreater{}$\\alpha$$\\cdot$$\\Omega$"
        );
    }

    #[test]
    fn powers_are_set_high() {
        assert_eq!(unit("N·m/(N·m)^2"), "N$\\cdot$m/(N$\\cdot$m)$^2$");
        assert_eq!((unit("m^-2/s²").as_str(), unit("m^10").as_str()), ("m$^{-2}$/s$^2$", "m$^{10}$"));
        assert_eq!((unit("count").as_str(), unit("a^b").as_str()), ("count", "a\\^{}b"));
    }
}
