//! HyperQueue's script: its command `hq` where the site has it, otherwise its package for Python, which comes without the command.

use super::submit::{Submission, quoted};
use std::fmt::Write as _;
use std::path::Path;

/// Whether the command `hq` is on the path.
pub(super) fn has_command() -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join("hq").is_file())
}

/// A shell script that submits an array by `hq`.
pub(super) fn by_command(of: &Submission, name: &str, list: &str, worker: &[String], logs: &Path) -> String {
    let (options, words) = (all_quoted(&of.options), all_quoted(worker));
    let logs = logs.display();
    format!(
        "exec hq submit --name {} --array {list} --cpus {} --time-request {}s --stdout none \\\n  --stderr \
         '{logs}/%{{JOB_ID}}_%{{TASK_ID}}.txt'{options} -- \\\n {words}\n",
        quoted(name),
        of.needs.cores,
        of.needs.seconds
    )
}

/// The same through `pip install hyperqueue`; the server is that of HQ_SERVER_DIR, or of ~/.hq-server.
pub(super) fn by_python(of: &Submission, name: &str, worker: &[String], logs: &Path) -> String {
    // A string, list or number in JSON is one in Python.
    let words = serde_json::json!({ "name": name, "worker": worker, "logs": logs.to_string_lossy(), "tasks": of.tasks });
    let literal = |key: &str| words[key].to_string();
    let mut text = "exec python3 - <<'END'\n".to_owned();
    for line in [
        "import os".to_owned(),
        "from datetime import timedelta".to_owned(),
        "from hyperqueue import Client, Job".to_owned(),
        "from hyperqueue.ffi.protocol import ResourceRequest".to_owned(),
        String::new(),
        format!("job = Job(name={}, max_fails=None)", literal("name")),
        format!(
            "needs = ResourceRequest(cpus={}, min_time=timedelta(seconds={}))",
            of.needs.cores, of.needs.seconds
        ),
        format!("worker = {}", literal("worker")),
        format!("logs = {}", literal("logs")),
        format!("for task in {}:", literal("tasks")),
        "    words = worker + [\"--task\", str(task)]".to_owned(),
        "    job.program(words, stdout=None, stderr=f\"{logs}/hyperqueue_{task}.txt\", resources=needs)"
            .to_owned(),
        "print(\"job\", Client(os.environ.get(\"HQ_SERVER_DIR\")).submit(job).id)".to_owned(),
        "END".to_owned(),
    ] {
        let _ = writeln!(text, "{line}");
    }
    text
}

fn all_quoted(words: &[String]) -> String {
    words.iter().map(|word| format!(" {}", quoted(word))).collect()
}
