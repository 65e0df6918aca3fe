//! Text for terminals: lines of a limited width.

/// Width of everything on the terminal (characters).
pub const WIDTH: usize = 80;

/// Each line of a text in lines of [`WIDTH`] characters at most, broken between words; what goes on is indented by `indent`
/// beyond its line. A word that is longer, such as a path, stands alone.
pub fn wrapped(text: &str, indent: usize) -> String {
    text.lines().map(|line| wrapped_line(line, indent)).collect::<Vec<_>>().join("\n")
}

fn wrapped_line(line: &str, indent: usize) -> String {
    if line.chars().count() <= WIDTH {
        return line.to_owned();
    }
    let lead = line.len() - line.trim_start().len();
    let hanging = " ".repeat(lead + indent);
    let (mut out, mut column, mut is_first) = (line[..lead].to_owned(), lead, true);
    for word in line[lead..].split(' ') {
        let width = word.chars().count();
        if !is_first && column + 1 + width > WIDTH {
            let kept = out.trim_end().len();
            out.truncate(kept);
            out.push('\n');
            out.push_str(&hanging);
            column = hanging.len();
        } else if !is_first {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        (column, is_first) = (column + width, false);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_between_words_and_short_ones_stay() {
        let word = "x".repeat(30);
        let text = format!("  - {word} {word} {word}\nshort   line\n{}", "y".repeat(100));
        let found = wrapped(&text, 2);
        let lines: Vec<&str> = found.lines().collect();
        assert_eq!(lines[0], format!("  - {word} {word}"));
        assert_eq!(lines[1], format!("    {word}"));
        assert_eq!(lines[2], "short   line");
        assert_eq!(lines.len(), 4);
    }
}
