//! Blocks of code in a Markdown file.

/// What the comment before a block says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    None,
    Long,
    Wheel,
    Importers,
    NotRun,
}

/// A block that could be run.
#[derive(Debug)]
pub struct Block {
    /// `sh` or `python`.
    pub language: String,
    /// Line of its first line, from 1.
    pub line: usize,
    pub mark: Mark,
    pub reason: String,
    pub code: String,
}

/// Blocks in `sh` and `python`, in their order.
pub fn blocks(text: &str) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    let (mut inside, mut wanted) = (false, false);
    let mut comment = "";
    for (number, line) in text.lines().enumerate() {
        match line.strip_prefix("```") {
            Some(_) if inside => inside = false,
            Some(language) => {
                inside = true;
                wanted = matches!(language, "sh" | "python");
                if wanted {
                    let (mark, reason) = mark(comment);
                    let (language, code) = (language.to_owned(), String::new());
                    found.push(Block { language, line: number + 2, mark, reason, code });
                }
            }
            None if inside && wanted => {
                let block = found.last_mut().expect("inside a block");
                block.code.push_str(line);
                block.code.push('\n');
            }
            None => {}
        }
        comment = if inside { "" } else { line };
    }
    found
}

fn mark(line: &str) -> (Mark, String) {
    let Some(said) = line.strip_prefix("<!-- ").and_then(|l| l.strip_suffix(" -->")) else {
        return (Mark::None, String::new());
    };
    let (name, reason) = said.split_once(':').unwrap_or((said, ""));
    let mark = match name {
        "long" => Mark::Long,
        "wheel" => Mark::Wheel,
        "importers" => Mark::Importers,
        "not run" => Mark::NotRun,
        _ => panic!("`{line}`: no such mark"),
    };
    (mark, reason.trim().to_owned())
}

#[test]
fn blocks_have_their_marks_and_lines() {
    let text = "a\n```sh\none\n```\n<!-- long: why not -->\n```python\ntwo\n\nthree\n```\n```text\n<!-- x -->\n```\n";
    let found = blocks(text);
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].line, found[0].mark, found[0].code.as_str()), (3, Mark::None, "one\n"));
    let b = &found[1];
    assert_eq!(
        (b.line, b.mark, b.reason.as_str(), b.code.as_str()),
        (7, Mark::Long, "why not", "two\n\nthree\n")
    );
}
