//! `meshfront view`: the page and the models, served on this machine alone.

use std::io::ErrorKind;
use std::net::{Ipv4Addr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Result, bail};
use axum::Router;
use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderName, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use meshfront::format;
use rust_embed::RustEmbed;
use serde_json::json;
use tower_http::services::ServeFile;

use crate::args::{Place, View};
use crate::dropped::{self, Temporary};
use crate::progress::Phases;
use crate::{build, input, interrupt, output, text};

/// The page, as `cargo xtask web` made it before this program was built; empty where it did not.
#[derive(RustEmbed)]
#[folder = "../../web/viewer/dist"]
#[allow_missing = true]
struct Page;

const NO_PAGE: &str = "this meshfront was built without its page: run `cargo xtask web`, then build it again";

pub fn run(args: &View, quiet: bool) -> Result<()> {
    if Page::get("index.html").is_none() {
        bail!(NO_PAGE);
    }
    // Before anything that takes time: a port that is taken is known at once.
    let listener = bind(args.port)?;
    if args.at.len() > args.files.len() {
        let (places, files) = (args.at.len(), args.files.len());
        return Err(
            output::Usage(format!("--at was given {places} times for {files} files: once per file is enough")).into()
        );
    }

    // Removed when dropped, and when interrupted.
    let temporary = Arc::new(Temporary::default());
    let mut models = vec![];
    for (i, file) in args.files.iter().enumerate() {
        let front = if input::is_front(file)? { file.clone() } else { build_in(&temporary.path()?, i, file, quiet)? };
        models.push(Model { url: url(i), name: file_name(file), front, place: args.at.get(i).copied() });
    }
    let card = describe(&models, args.credit.as_deref());
    let router = dropped::route(router(models, card), temporary.clone(), quiet).layer(middleware::from_fn(guard));

    let address = format!("http://{}/", listener.local_addr()?);
    // Whoever reads the address may interrupt from then on.
    interrupt::ends_well();
    text::print(&format!("{address}\n"))?;
    if !quiet {
        let files: Vec<_> = args.files.iter().map(|file| file.display().to_string()).collect();
        eprintln!("Serving {} on this machine only; Ctrl-C to stop.", files.join(", "));
    }
    if !args.no_open
        && let Err(e) = open::that_detached(&address)
    {
        eprintln!("No browser could be started ({e}): open the address above in one.");
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    runtime.block_on(async {
        listener.set_nonblocking(true)?;
        let listener = tokio::net::TcpListener::from_std(listener)?;
        axum::serve(listener, router).await
    })?;
    drop(temporary);
    Ok(())
}

struct Model {
    /// Relative to the page.
    url: String,
    name: String,
    front: PathBuf,
    place: Option<Place>,
}

fn url(i: usize) -> String {
    if i == 0 { "model.front".into() } else { format!("model-{}.front", i + 1) }
}

fn file_name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Builds a hierarchy that is kept only while it is looked at.
fn build_in(folder: &Path, i: usize, source: &Path, quiet: bool) -> Result<PathBuf> {
    let front = folder.join(url(i));
    build::build_plainly(source, &front, &Phases::new(quiet))?;
    if !quiet {
        let path = source.display();
        eprintln!(
            "The hierarchy of {path} is kept only while it is looked at; `meshfront build {path} -o …` keeps it."
        );
    }
    Ok(front)
}

fn bind(port: u16) -> Result<TcpListener> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|e| match e.kind() {
        ErrorKind::AddrInUse => anyhow::anyhow!(
            "port {port} is taken by another program: choose another with --port, or leave --port out to get a free one"
        ),
        ErrorKind::PermissionDenied => {
            anyhow::anyhow!("port {port} may not be used by an ordinary user: choose one above 1023 with --port")
        }
        _ => anyhow::Error::new(e).context(format!("port {port} on 127.0.0.1 cannot be opened")),
    })
}

/// What the page asks for first. The page itself tells of a damaged file.
fn describe(models: &[Model], credit: Option<&str>) -> serde_json::Value {
    let names: Vec<&str> = models.iter().map(|model| &*model.name).collect();
    let cards: Vec<_> = models
        .iter()
        .map(|model| {
            let mut card = card(&model.name, &model.url, &model.front);
            if let Some(Place { at, scale }) = model.place {
                card["at"] = at.to_array().into();
                card["scale"] = scale.into();
            }
            card
        })
        .collect();
    let mut card = json!({ "name": names.join(", "), "models": cards, "build": true });
    if let Some(credit) = credit {
        card["credit"] = credit.into();
    }
    card
}

/// A model of the page, without a place.
pub fn card(name: &str, url: &str, front: &Path) -> serde_json::Value {
    let mut card = json!({ "name": name, "url": url });
    if let Ok(info) = format::inspect_file(front) {
        card["source"] = json!({ "vertices": info.source_vertices, "triangles": info.source_triangles });
    }
    card
}

fn router(models: Vec<Model>, card: serde_json::Value) -> Router {
    let card = card.to_string();
    let mut router =
        Router::new().route("/model.json", get(|| async { ([(header::CONTENT_TYPE, "application/json")], card) }));
    for model in models {
        router = router.route_service(&format!("/{}", model.url), ServeFile::new(model.front));
    }
    router.fallback(page)
}

/// A file of the page.
async fn page(method: Method, uri: Uri) -> Response {
    if method != Method::GET && method != Method::HEAD {
        return StatusCode::METHOD_NOT_ALLOWED.into_response();
    }
    let path = match uri.path().trim_start_matches('/') {
        "" => "index.html",
        path => path,
    };
    match Page::get(path) {
        Some(file) => {
            let kind = file.metadata.mimetype().to_owned();
            ([(header::CONTENT_TYPE, kind)], Body::from(file.data.into_owned())).into_response()
        }
        None => (StatusCode::NOT_FOUND, "no such file\n").into_response(),
    }
}

/// Headers that every answer has.
const ALWAYS: [(HeaderName, HeaderValue); 5] = [
    // The model may be another one the next time that this port serves one.
    (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
    (header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff")),
    // Isolated from other sites: their pages cannot read the model, and the worker gets a fine clock.
    (HeaderName::from_static("cross-origin-opener-policy"), HeaderValue::from_static("same-origin")),
    (HeaderName::from_static("cross-origin-embedder-policy"), HeaderValue::from_static("require-corp")),
    (HeaderName::from_static("cross-origin-resource-policy"), HeaderValue::from_static("same-origin")),
];

/// Refuses requests that came here under another name: a foreign page whose name was rebound to this machine
/// could read the model otherwise. Any port is right, since people forward ports.
async fn guard(request: Request, next: Next) -> Response {
    let host = request.headers().get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
        _ => host,
    };
    let mut response = if ["127.0.0.1", "localhost", "[::1]"].iter().any(|local| name.eq_ignore_ascii_case(local)) {
        next.run(request).await
    } else {
        (StatusCode::FORBIDDEN, "this server answers to 127.0.0.1 and localhost only\n").into_response()
    };
    response.headers_mut().extend(ALWAYS);
    response
}
