//! Plain-text symbols as a reader expects them in print.

/// `mu_1` becomes μ₁, `alpha_inf` α∞, `chi^2` χ², `mm^2` mm², and so on, anywhere in a text.
pub fn pretty(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut word = String::new();
    let mut chars = text.chars().chain(std::iter::once('\0')).peekable();
    while let Some(c) = chars.next() {
        // An exponent may have decimals.
        let is_point = c == '.' && word.contains('^') && chars.peek().is_some_and(char::is_ascii_digit);
        if c.is_ascii_alphanumeric() || c == '_' || c == '^' || is_point {
            word.push(c);
        } else {
            out.push_str(&pretty_word(&word));
            word.clear();
            if c != '\0' {
                out.push(c);
            }
        }
    }
    for digit in '0'..='9' {
        out = out.replace(&format!(" -{digit}"), &format!(" −{digit}"));
    }
    out.replace("lambda*", "λ*").replace(" +- ", " ± ").replace(" x ", " × ")
}

fn pretty_word(word: &str) -> String {
    if let Some((base, power)) = word.split_once('^') {
        let power: String = power.chars().map(superscript).collect();
        return format!("{}{power}", pretty_word(base));
    }
    if word == "K0" {
        return "K₀".to_owned();
    }
    match word.split_once('_') {
        Some((base, "inf")) if is_symbol(base) => format!("{}∞", greek(base)),
        Some((base, index)) if is_symbol(base) && index.chars().all(|c| c.is_ascii_digit()) => {
            format!("{}{}", greek(base), index.chars().map(subscript).collect::<String>())
        }
        Some(("k", "f")) => "kᶠ".to_owned(),
        Some(("mu", "FR")) => "μᶠᴿ".to_owned(),
        _ if matches!(word, "chi" | "sigma" | "rho") => greek(word),
        _ => word.to_owned(),
    }
}

fn is_symbol(base: &str) -> bool {
    base.len() == 1 || greek(base) != base
}

fn greek(name: &str) -> String {
    let letter = match name {
        "mu" => "μ",
        "alpha" => "α",
        "eta" => "η",
        "tau" => "τ",
        "chi" => "χ",
        "sigma" => "σ",
        "rho" => "ρ",
        other => other,
    };
    letter.to_owned()
}

/// An integer as an exponent: `-14` becomes ⁻¹⁴.
pub(crate) fn exponent(value: &str) -> String {
    value.chars().map(superscript).collect()
}

fn subscript(digit: char) -> char {
    digit.to_digit(10).and_then(|d| char::from_u32(0x2080 + d)).unwrap_or(digit)
}

fn superscript(c: char) -> char {
    match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '.' => '·',
        other => other.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(other),
    }
}

#[cfg(test)]
mod tests {
    use super::pretty;

    #[test]
    fn symbols_are_set_as_in_print() {
        for (plain, set) in [
            ("mu_1 and alpha_inf enter as G_1 = mu_1 alpha_1 / 2", "μ₁ and α∞ enter as G₁ = μ₁ α₁ / 2"),
            ("chi^2 in mm^2", "χ² in mm²"),
            ("alpha_inf alpha_2^5.10. End", "α∞ α₂⁵·¹⁰. End"),
            ("in mm^2.", "in mm²."),
            ("material_x of file_1", "material_x of file_1"),
            ("K0 rho g / mu_FR", "K₀ ρ g / μᶠᴿ"),
            ("lambda*", "λ*"),
            ("mu_2 = -161 Pa (correlation -1.0000)", "μ₂ = −161 Pa (correlation −1.0000)"),
        ] {
            assert_eq!(pretty(plain), set);
        }
    }
}
