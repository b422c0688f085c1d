//! Meshes that are dropped on the page: sent here, built, and served.
//!
//! `POST build?name=FILE` with the file as its body answers with a line of JSON for each step (`{"phase":"read","fraction":0.4}`; no
//! fraction where nobody knows), and at the end with `{"model":{"name":…,"url":…,"source":…}}` as in `model.json`, or with
//! `{"error":…,"remedy":…}`. Only the page may ask: a foreign page can neither set the header that is asked for, nor claim to be
//! this one.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result};
use axum::Router;
use axum::body::Body;
use axum::extract::{DefaultBodyLimit, Path as Name, Query, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use http_body_util::BodyExt;
use http_body_util::channel::{Channel, Sender};
use serde::Deserialize;
use serde_json::json;
use tempfile::TempDir;
use tokio::io::AsyncWriteExt;
use tokio::sync::mpsc;
use tower_http::services::ServeFile;

use crate::progress::Phases;
use crate::{build, interrupt};

/// What a page says that asks for a build.
const HEADER: (&str, &str) = ("x-meshfront", "build");
/// More than any mesh that fits into the memory of an ordinary machine; a disk must not run full by accident.
const MOST_BYTES: u64 = 16 << 30;

/// A folder that is there once it is needed, until the viewer ends.
#[derive(Default)]
pub struct Temporary(Mutex<Option<TempDir>>);

impl Temporary {
    /// Its path.
    pub fn path(&self) -> Result<PathBuf> {
        let mut folder = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(folder) = &*folder {
            return Ok(folder.path().to_owned());
        }
        let new = tempfile::Builder::new().prefix("meshfront-view-").tempdir().context("no temporary folder")?;
        interrupt::remove_when_interrupted(new.path());
        Ok(folder.insert(new).path().to_owned())
    }
}

/// Dropped files, one built at a time.
#[derive(Clone)]
struct Drops {
    temporary: Arc<Temporary>,
    count: Arc<AtomicUsize>,
    turn: Arc<tokio::sync::Mutex<()>>,
    quiet: bool,
}

/// Adds `build`, and `dropped/N.front` for what was built.
pub fn route(router: Router, temporary: Arc<Temporary>, quiet: bool) -> Router {
    let drops = Drops { temporary, count: Arc::default(), turn: Arc::default(), quiet };
    let routes = Router::new().route("/build", post(receive)).layer(DefaultBodyLimit::disable());
    router.merge(routes.route("/dropped/{file}", get(serve)).with_state(drops))
}

impl Drops {
    /// Where a finished file lies.
    fn front(&self, number: usize) -> Result<PathBuf> {
        Ok(self.temporary.path()?.join(format!("dropped-{number}.front")))
    }
}

async fn serve(State(drops): State<Drops>, Name(file): Name<String>, request: Request) -> Response {
    let number = file.strip_suffix(".front").and_then(|number| number.parse().ok());
    let built = number.filter(|number| (1..=drops.count.load(Ordering::Relaxed)).contains(number));
    let Some(Ok(front)) = built.map(|number| drops.front(number)) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    match ServeFile::new(front).try_call(request).await {
        Ok(response) => response.into_response(),
        Err(_) => StatusCode::NOT_FOUND.into_response(),
    }
}

#[derive(Deserialize)]
struct Asked {
    name: String,
}

async fn receive(State(drops): State<Drops>, headers: HeaderMap, Query(asked): Query<Asked>, body: Body) -> Response {
    if !comes_from_the_page(&headers) {
        return (StatusCode::FORBIDDEN, "only the page of this server may ask for a build\n").into_response();
    }
    let (sender, answer) = Channel::new(64);
    tokio::spawn(answer_with(drops, asked.name, body, sender));
    ([(header::CONTENT_TYPE, "application/x-ndjson")], Body::new(answer)).into_response()
}

fn comes_from_the_page(headers: &HeaderMap) -> bool {
    let get = |name: &str| headers.get(name).and_then(|value| value.to_str().ok());
    // Browsers say where a request comes from, and let no foreign page set the header without asking first.
    let own = match (get("origin"), get("host")) {
        (Some(origin), Some(host)) => origin.split_once("://").is_some_and(|(_, of)| of.eq_ignore_ascii_case(host)),
        (origin, _) => origin.is_none(),
    };
    own && get(HEADER.0) == Some(HEADER.1)
}

/// Sends lines until the work is over. Who left does not want them any more.
async fn answer_with(drops: Drops, name: String, body: Body, mut sender: Sender<axum::body::Bytes>) {
    let (tell, mut told) = mpsc::unbounded_channel();
    let work = tokio::spawn(async move { store_and_build(&drops, &name, body, tell).await });
    while let Some(line) = told.recv().await {
        if send(&mut sender, &line).await.is_err() {
            break;
        }
    }
    let last = match work.await {
        Ok(Ok(model)) => json!({ "model": model }),
        Ok(Err(error)) => sentence(&format!("{error:#}")),
        Err(_) => sentence("the build broke down; `meshfront build` on the file may tell more"),
    };
    let _ = send(&mut sender, &last).await;
}

async fn send(sender: &mut Sender<axum::body::Bytes>, line: &serde_json::Value) -> Result<(), ()> {
    sender.send_data(format!("{line}\n").into()).await.map_err(|_| ())
}

/// Messages are a sentence, and after a semicolon what to do.
fn sentence(message: &str) -> serde_json::Value {
    let (error, remedy) = message.split_once("; ").unwrap_or((message, ""));
    json!({ "error": error, "remedy": remedy })
}

async fn store_and_build(
    drops: &Drops,
    name: &str,
    mut body: Body,
    tell: mpsc::UnboundedSender<serde_json::Value>,
) -> Result<serde_json::Value> {
    // What the page calls it is no path here.
    let name = Path::new(name).file_name().context("the file has no name")?.to_string_lossy().into_owned();
    let _ = tell.send(json!({ "phase": "wait" }));
    let _turn = drops.turn.lock().await;
    let number = drops.count.fetch_add(1, Ordering::Relaxed) + 1;
    let folder = drops.temporary.path()?;
    // Gone with everything in it when this is over.
    let own = tempfile::Builder::new().prefix("upload-").tempdir_in(&folder).context("no temporary folder")?;
    let source = own.path().join(&name);
    let mut file = tokio::fs::File::create(&source).await.with_context(|| format!("{name} cannot be stored"))?;
    let mut stored = 0;
    while let Some(frame) = body.frame().await {
        let frame = frame.with_context(|| format!("{name} broke off after {stored} bytes"))?;
        let Ok(data) = frame.into_data() else { continue };
        stored += data.len() as u64;
        anyhow::ensure!(stored <= MOST_BYTES, "{name} is too large to be sent; build it with `meshfront build`");
        file.write_all(&data).await.with_context(|| format!("{name} cannot be stored"))?;
    }
    file.flush().await.with_context(|| format!("{name} cannot be stored"))?;
    drop(file);

    let url = format!("dropped/{number}.front");
    let front = drops.front(number)?;
    let target = front.clone();
    let (quiet, shown) = (drops.quiet, name.clone());
    let hidden = format!("{}{}", own.path().display(), std::path::MAIN_SEPARATOR);
    let built = tokio::task::spawn_blocking(move || -> Result<()> {
        let phases = Phases::told(quiet, move |phase, fraction| {
            let fraction = fraction.map(|part| (part * 1000.0).round() / 1000.0);
            let _ = tell.send(json!({ "phase": phase, "fraction": fraction }));
        });
        build::build_plainly(&source, &target, &phases)
    });
    // Where the file lies for the moment is of no interest.
    built.await?.map_err(|error| anyhow::anyhow!(format!("{error:#}").replace(&hidden, "")))?;
    if !drops.quiet {
        eprintln!("{shown} was dropped on the page and built; `meshfront build` keeps what it makes.");
    }
    Ok(crate::view::card(&name, &url, &front))
}
