//! HTTP: requests in, answers out, a thread per instance of the FMU.

use super::{Worker, answer};
use serde_json::Value;
use std::io::Read;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use thiserror::Error;
use tiny_http::{Header, Request, Response, Server};

/// How often a thread without work asks whether to stop.
const PATIENCE: Duration = Duration::from_millis(100);
/// No request is longer: a vector of a million numbers.
const LONGEST: u64 = 1 << 25;

/// A server that cannot listen.
#[derive(Debug, Error)]
#[error("cannot listen on {address}: {reason}; choose another with --port or --address")]
pub struct ServerError {
    address: SocketAddr,
    reason: String,
}

/// Answers requests until `stop` is raised; `listening` is told the address once it can be reached.
///
/// # Errors
/// When it cannot listen there.
pub fn serve(
    address: SocketAddr,
    workers: Vec<Worker>,
    stop: &AtomicBool,
    listening: impl FnOnce(SocketAddr),
) -> Result<(), ServerError> {
    let refused = |reason: String| ServerError { address, reason };
    let server = Server::http(address).map_err(|error| refused(error.to_string()))?;
    listening(server.server_addr().to_ip().unwrap_or(address));
    std::thread::scope(|scope| {
        for mut worker in workers {
            let server = &server;
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    // A connection that breaks is the client's affair.
                    if let Ok(Some(request)) = server.recv_timeout(PATIENCE) {
                        let _ = handle(&mut worker, request);
                    }
                }
            });
        }
    });
    Ok(())
}

fn handle(worker: &mut Worker, mut request: Request) -> std::io::Result<()> {
    let mut body = String::new();
    request.as_reader().take(LONGEST).read_to_string(&mut body)?;
    let (status, value) = answer(worker, request.url(), &body);
    request.respond(json(status, &value))
}

fn json(status: u16, value: &Value) -> Response<std::io::Cursor<Vec<u8>>> {
    let response = Response::from_string(value.to_string()).with_status_code(status);
    match Header::from_bytes("Content-Type", "application/json") {
        Ok(header) => response.with_header(header),
        Err(()) => response,
    }
}
