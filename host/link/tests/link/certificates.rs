//! Certificates of an authority that a test makes.

use std::fs;
use std::path::{Path, PathBuf};

use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, DnType, IsCa, KeyPair};
use tempfile::TempDir;

/// An authority, and a folder for its certificate, those that it signs, and configurations that name them.
pub struct Authority {
    folder: TempDir,
    issuer: CertifiedIssuer<'static, KeyPair>,
}

/// A certificate of this name for this machine's own address.
fn named(name: &str) -> CertificateParams {
    let mut params = CertificateParams::new(["127.0.0.1".to_owned()]).unwrap();
    params.distinguished_name.push(DnType::CommonName, name);
    params
}

impl Authority {
    /// Its certificate is `authority.pem`.
    pub fn new() -> Self {
        let mut params = named("authority");
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        let issuer = CertifiedIssuer::self_signed(params, KeyPair::generate().unwrap()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("authority.pem"), issuer.pem()).unwrap();
        Self { folder, issuer }
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Signs a certificate: `NAME.pem`, its key `NAME.key`.
    pub fn sign(&self, name: &str) {
        let key = KeyPair::generate().unwrap();
        let certificate = named(name).signed_by(&key, &self.issuer).unwrap();
        fs::write(self.folder().join(format!("{name}.pem")), certificate.pem()).unwrap();
        fs::write(self.folder().join(format!("{name}.key")), key.serialize_pem()).unwrap();
    }

    /// Writes a configuration, in which files of the folder stand by their names alone.
    pub fn config(&self, name: &str, text: &str) -> PathBuf {
        let mut text = text.to_owned();
        for entry in fs::read_dir(self.folder()).unwrap() {
            let path = entry.unwrap().path();
            let file = path.file_name().unwrap().to_str().unwrap();
            text = text.replace(&format!("\"{file}\""), &format!("\"{}\"", path.display()));
        }
        let path = self.folder().join(name);
        fs::write(&path, text).unwrap();
        path
    }
}
