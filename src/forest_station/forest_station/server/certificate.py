"""A certificate for TLS: the user's own, or one that the station makes and keeps for the next time."""

import datetime
import ipaddress
import os
import socket
import ssl
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

VALID = datetime.timedelta(days=365)
RENEWED = datetime.timedelta(days=30)  # before its end
NOT_YET = datetime.timedelta(days=1)  # by which a page's clock may be behind ours


class CertificateError(ValueError):
    """A certificate or key cannot be used; the text names the file and what is allowed."""


def own_certificate(certificate: str, key: str) -> ssl.SSLContext:
    """Return what serves TLS with the user's certificate.

    Raises:
        CertificateError: one of both files is missing, or they do not fit each other.
    """
    if not (certificate and key):
        raise CertificateError("certificate and key are given together, or neither")
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    try:
        context.load_cert_chain(certificate, key)
    except (OSError, ssl.SSLError) as error:
        reason = getattr(error, "reason", None) or getattr(error, "strerror", None)
        text = f"certificate {certificate} with key {key}: {reason}; allowed: PEM files of a pair"
        raise CertificateError(text) from error
    return context


def self_made_certificate(host: str, folder: Path) -> tuple[ssl.SSLContext, str]:
    """Return what serves TLS with a certificate of our own, and its fingerprint (SHA-256).

    It is kept in the folder, so that a browser has to be told only once to trust it.

    Raises:
        OSError: the folder cannot be written.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    file = folder / f"{host.replace(':', '_')}.pem"
    told = _kept(file)
    if told is None:
        told = _made(host, file)
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.load_cert_chain(file)
    return context, told.fingerprint(hashes.SHA256()).hex(":").upper()


def kept_in() -> Path:
    """Return where certificates of our own are kept."""
    state = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(state) / "forest-crane"


def _kept(file: Path) -> x509.Certificate | None:
    """Return the certificate in a file, if it is still good for a while."""
    try:
        found = x509.load_pem_x509_certificate(file.read_bytes())
    except (OSError, ValueError):
        return None
    return found if found.not_valid_after_utc - RENEWED > _now() else None


def _made(host: str, file: Path) -> x509.Certificate:
    """Make a certificate, and write it and its key into a file that nobody else can read."""
    key, now = ec.generate_private_key(ec.SECP256R1()), _now()
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "forest-crane station")])
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - NOT_YET)
        .not_valid_after(now + VALID)
        .add_extension(x509.SubjectAlternativeName(_names(host)), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .sign(key, hashes.SHA256())
    )
    secret = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    file.unlink(missing_ok=True)
    with os.fdopen(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as sink:
        sink.write(made.public_bytes(serialization.Encoding.PEM) + secret)
    return made


def _names(host: str) -> list[x509.GeneralName]:
    """Return what a page may call this computer."""
    names: list[x509.GeneralName] = [x509.DNSName(name) for name in ("localhost", socket.gethostname())]
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return [*names, x509.DNSName(host)]
    return names if address.is_unspecified else [*names, x509.IPAddress(address)]


def _now() -> datetime.datetime:
    return datetime.datetime.now(datetime.timezone.utc)
