//! Who may ask: only the page itself, and programs on this machine or with the token.
//!
//! A page elsewhere in the same browser can send requests here. It cannot read the replies, since
//! nothing here allows that; these checks keep it from having any effect, and from pretending by
//! its name to be this page.

use std::net::IpAddr;
use std::sync::Arc;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::api_error::ApiError;

/// What the page may load and do: nothing but what comes from here.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";

const SEC_FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");
const SEC_FETCH_DEST: HeaderName = HeaderName::from_static("sec-fetch-dest");

/// Who may ask.
#[derive(Debug)]
pub(crate) struct Access {
    /// What a browser has to show if the page can be reached from other machines.
    token: Option<String>,
    /// The name of the cookie that shows it: browsers give those of one port to all others.
    cookie: String,
}

impl Access {
    pub(crate) fn new(token: Option<String>, port: u16) -> Self {
        Self { token, cookie: format!("mmsim-{port}") }
    }

    /// The token to show, in the address of the page.
    pub(crate) fn query(&self) -> String {
        self.token.as_ref().map(|token| format!("?token={token}")).unwrap_or_default()
    }

    fn check(&self, method: &Method, uri: &Uri, headers: &HeaderMap) -> Result<(), ApiError> {
        let host = self.check_host(uri, headers)?;
        Self::check_site(method, uri, headers, &host)?;
        match &self.token {
            Some(token) if !self.shows(token, uri, headers) => Err(ApiError::new(
                StatusCode::UNAUTHORIZED,
                "expected the token that mmsim printed at its start, as in http://HOST:PORT/?token=TOKEN",
            )),
            _ => Ok(()),
        }
    }

    /// A name that others may point at this machine is no name of ours. With a token that does not
    /// matter: a browser shows it only to the name to which it was given.
    fn check_host(&self, uri: &Uri, headers: &HeaderMap) -> Result<String, ApiError> {
        let mut hosts = headers.get_all(header::HOST).iter();
        let host = match (hosts.next(), hosts.next(), uri.authority()) {
            (Some(host), None, None) => host.to_str().unwrap_or_default().to_ascii_lowercase(),
            (host, _, authority) => {
                let text = format!("expected one host, found {host:?} and {authority:?}");
                return Err(ApiError::bad(text));
            }
        };
        if self.token.is_some() || is_loopback(&host) {
            return Ok(host);
        }
        let text =
            format!("expected a name of this machine as host, such as localhost, found {host:?}");
        Err(ApiError::new(StatusCode::FORBIDDEN, text))
    }

    /// What a browser sends says which page it is for.
    fn check_site(
        method: &Method,
        uri: &Uri,
        headers: &HeaderMap,
        host: &str,
    ) -> Result<(), ApiError> {
        let refuse = |found: &str| {
            let text = format!("expected a request of the page at {host}, found {found}");
            Err(ApiError::new(StatusCode::FORBIDDEN, text))
        };
        let origin = headers.get(header::ORIGIN).map(|origin| origin.to_str().unwrap_or("?"));
        match origin {
            Some(origin) if !is_origin_of(origin, host) => {
                return refuse(&format!("one of {origin:?}"));
            }
            // Every browser tells the origin of what may change something.
            None if *method != Method::GET && *method != Method::HEAD => {
                return refuse("one without the header Origin");
            }
            _ => {}
        }
        let told = |name| headers.get(name).map(|value: &HeaderValue| value.as_bytes());
        match told(SEC_FETCH_SITE) {
            None | Some(b"same-origin" | b"none") => Ok(()),
            // Somebody followed a link to the page.
            Some(_) if uri.path() == "/" && told(SEC_FETCH_DEST) == Some(b"document") => Ok(()),
            Some(_) => refuse("one of another site"),
        }
    }

    fn shows(&self, token: &str, uri: &Uri, headers: &HeaderMap) -> bool {
        let cookies =
            headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
        let shown = cookies.flat_map(|cookies| cookies.split(';')).filter_map(|cookie| {
            let (name, value) = cookie.trim().split_once('=')?;
            (name == self.cookie).then_some(value)
        });
        shown.chain(token_of(uri)).any(|shown| same(shown, token))
    }

    /// The cookie for a browser that came with the token in the address.
    fn cookie_for(&self, uri: &Uri) -> Option<HeaderValue> {
        let (token, _) = (self.token.as_ref()?, token_of(uri)?);
        let cookie = format!("{}={token}; Path=/; HttpOnly; SameSite=Lax", self.cookie);
        HeaderValue::from_str(&cookie).ok()
    }
}

/// Lets in who may ask, and sets the headers that every reply has.
pub(crate) async fn guard(
    State(access): State<Arc<Access>>,
    request: Request,
    next: Next,
) -> Response {
    let checked = access.check(request.method(), request.uri(), request.headers());
    let mut response = match (checked, access.cookie_for(request.uri())) {
        // Out of the address, where it could be read over a shoulder.
        (Ok(()), Some(cookie)) if request.uri().path() == "/" => {
            let headers =
                [(header::LOCATION, HeaderValue::from_static("/")), (header::SET_COOKIE, cookie)];
            (StatusCode::SEE_OTHER, headers).into_response()
        }
        (Ok(()), _) => next.run(request).await,
        (Err(refusal), _) => refusal.into_response(),
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    // Elsewhere, browsers complain of it unless the connection is encrypted.
    if access.token.is_none() {
        let name = HeaderName::from_static("cross-origin-opener-policy");
        headers.insert(name, HeaderValue::from_static("same-origin"));
    }
    headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("no-store"));
    response
}

/// Whether a host, with or without a port, is this machine and nobody else: a name that no name
/// service decides about.
fn is_loopback(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let address = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    name == "localhost"
        || address.parse().is_ok_and(|address: IpAddr| address.to_canonical().is_loopback())
}

fn is_origin_of(origin: &str, host: &str) -> bool {
    let rest = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
    rest.is_some_and(|rest| rest.eq_ignore_ascii_case(host))
}

fn token_of(uri: &Uri) -> Option<&str> {
    uri.query()?.split('&').find_map(|pair| pair.strip_prefix("token="))
}

/// Compares without telling by the time it takes how much is right.
fn same(shown: &str, token: &str) -> bool {
    let differing = shown.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    shown.len() == token.len() && differing == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(access: &Access, method: &Method, uri: &str, headers: &[(&str, &str)]) -> u16 {
        let headers = headers
            .iter()
            .map(|(name, value)| (name.parse::<HeaderName>().unwrap(), value.parse().unwrap()))
            .fold(HeaderMap::new(), |mut headers, (name, value)| {
                headers.append(name, value);
                headers
            });
        let checked = access.check(method, &uri.parse().unwrap(), &headers);
        checked.map_or_else(|refusal| refusal.status.as_u16(), |()| 200)
    }

    const HOST: (&str, &str) = ("host", "127.0.0.1:6575");

    #[test]
    fn only_names_that_are_always_this_machine_are_hosts() {
        let access = Access::new(None, 6575);
        let get = |host| check(&access, &Method::GET, "/", &[("host", host)]);
        for host in [
            "127.0.0.1:6575",
            "localhost:6575",
            "LOCALHOST",
            "[::1]:6575",
            "127.0.0.2",
            "localhost:8080",
        ] {
            assert_eq!(get(host), 200, "{host}");
        }
        for host in [
            "",
            "evil.example:6575",
            "localhost.evil.example",
            "127.0.0.1.evil.example",
            "192.168.1.7:6575",
            "localhost:evil.example",
            "0x7f.1",
            "[::1",
        ] {
            assert_eq!(get(host), 403, "{host}");
        }
        assert_eq!(check(&access, &Method::GET, "/", &[]), 400);
        assert_eq!(check(&access, &Method::GET, "/", &[HOST, HOST]), 400);
        assert_eq!(check(&access, &Method::GET, "http://evil.example/", &[HOST]), 400);
    }

    #[test]
    fn pages_elsewhere_are_refused() {
        let access = Access::new(None, 6575);
        let ask = |method: &Method, path, name, value| {
            check(&access, method, path, &[HOST, (name, value)])
        };
        for method in [Method::GET, Method::POST] {
            assert_eq!(ask(&method, "/api/maze", "origin", "http://127.0.0.1:6575"), 200);
            for origin in [
                "http://evil.example",
                "http://127.0.0.1:3000",
                "http://localhost:6575",
                "null",
                "",
                "file://",
            ] {
                assert_eq!(ask(&method, "/api/maze", "origin", origin), 403, "{origin}");
            }
        }
        assert_eq!(check(&access, &Method::POST, "/api/maze", &[HOST]), 403, "no origin");
        assert_eq!(check(&access, &Method::GET, "/api/mazes", &[HOST]), 200);
        for (site, status) in
            [("same-origin", 200), ("none", 200), ("same-site", 403), ("cross-site", 403)]
        {
            assert_eq!(ask(&Method::GET, "/api/mazes", "sec-fetch-site", site), status);
        }
        let follow = |dest| {
            let headers = [HOST, ("sec-fetch-site", "cross-site"), ("sec-fetch-dest", dest)];
            check(&access, &Method::GET, "/", &headers)
        };
        assert_eq!((follow("document"), follow("iframe")), (200, 403));
    }

    #[test]
    fn a_token_is_asked_for_where_others_can_reach_the_page() {
        let access = Access::new(Some("secret".into()), 6575);
        let get = |uri, headers: &[(&str, &str)]| {
            check(&access, &Method::GET, uri, &[&[("host", "mouse.lan:6575")], headers].concat())
        };
        assert_eq!(get("/", &[]), 401);
        assert_eq!(get("/?token=secret", &[]), 200);
        assert_eq!(get("/api/mazes?x=1&token=secret", &[]), 200);
        for uri in
            ["/?token=", "/?token=secre", "/?token=secret2", "/?token=Secret", "/?xtoken=secret"]
        {
            assert_eq!(get(uri, &[]), 401, "{uri}");
        }
        assert_eq!(get("/", &[("cookie", "a=b; mmsim-6575=secret")]), 200);
        assert_eq!(get("/", &[("cookie", "mmsim-6576=secret")]), 401);
        assert_eq!(
            get("/", &[("cookie", "mmsim-6575=secret"), ("origin", "http://evil.example")]),
            403
        );
        assert_eq!(access.query(), "?token=secret");
        let cookie = access.cookie_for(&"/?token=secret".parse().unwrap()).unwrap();
        assert_eq!(cookie, "mmsim-6575=secret; Path=/; HttpOnly; SameSite=Lax");
    }
}
