"""What the image holds of others: SPDX 2.3 as JSON, their licence texts, and where their sources are."""

import gzip
import hashlib
import json
import pathlib
import re
import time
from urllib.parse import quote

# In stofd: libraries are linked statically, Eigen is compiled in. (package of Debian, what of it).
LIBRARIES = (("libc6-dev", "glibc"), ("libstdc++-14-dev", "libstdc++"), ("libgcc-14-dev", "libgcc"),
             ("libgpiod-dev", "libgpiod"), ("libusb-1.0-0-dev", "libusb"), ("libsodium-dev", "libsodium"),
             ("libeigen3-dev", "Eigen"))
# Packages of libraries that are not named after them (Debian Policy, section 8.1).
PACKAGES = {**dict.fromkeys(("ld-linux-aarch64.so.1", "libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1"), "libc6"),
            "libz.so.1": "zlib1g", "libjpeg.so.62": "libjpeg62-turbo"}
# Libraries that lie in the package of another one.
BESIDE = {"libcamera-base": "libcamera", "liblttng-ust-tracepoint": "liblttng-ust"}
CHANGE = re.compile(r"^(\S+) \(([^)]+)\)")
COMMON = pathlib.Path("/usr/share/common-licenses")  # of Debian's base-files: what copyright files refer to
REFERENCE = re.compile(rb"/usr/share/common-licenses/([A-Za-z0-9][A-Za-z0-9.-]*[A-Za-z0-9])")
OFFER = """Sources of what this image holds

stof: {home}, version {version}.
Everything else are packages of {origin}, unchanged but for the signatures of modules, which are left out. Their
sources, of exactly these versions:
{lines}
Debian's snapshot archive keeps each source package that Debian ever had, by name and version.
Whoever got this image from somebody who gives it away may ask him for these sources, for three years from
then on, for no more than the cost of the copy (GPL version 2, section 3b; GPL version 3, section 6).
The scripts that built the image are in stof's own sources: scripts/image, toolchains/.
"""
HOME = "the repository that this image was built from"


class SbomError(Exception):
    """One line: what, where, what to do."""


class Package:
    """An unpacked package: its source's name and version, and its licence text. distribution: as purls name it."""

    def __init__(self, root, package, name, distribution="debian"):
        folder = pathlib.Path(root) / "usr" / "share" / "doc" / package
        logs = [path for path in (folder / "changelog.Debian.gz", folder / "changelog.gz") if path.exists()]
        texts = folder / "copyright"
        if not logs or not texts.exists():
            raise SbomError(f"{folder}: no changelog and copyright: the package {package} is not whole; unpack it anew")
        change = CHANGE.match(gzip.decompress(logs[0].read_bytes()).decode(errors="replace").split("\n", 1)[0])
        if not change:
            raise SbomError(f"{logs[0]}: does not begin with NAME (VERSION): unpack {package} anew")
        self.name = name
        self.package = package
        self.distribution = distribution
        # Signed kernels are made of the binaries of source package linux, of the same version.
        self.source, self.version = re.sub(r"^linux-signed-\w+$", "linux", change[1]), change[2]
        self.licence = texts.read_bytes()


def has(root, package):
    return (pathlib.Path(root) / "usr" / "share" / "doc" / package).is_dir()


def package_of(root, library):
    """The package of a shared library's name, of those that are unpacked to `root`."""
    name, _, version = library.partition(".so.")
    name = BESIDE.get(name, name).replace("_", "-")
    usual = f"{name}{'-' if name[-1:].isdigit() else ''}{version}".lower()
    for package in (PACKAGES.get(library, usual), f"{usual}t64"):
        if has(root, package):
            return package
    raise SbomError(f"{root}: no package of library {library}: unpack {usual} there, or name it in PACKAGES of scripts/imaging/sbom.py")


def _spdx_id(text):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", text)


def document(image, version, packages, epoch):
    """SPDX 2.3 of what is in an image of that name, bytes of JSON."""
    stamp = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(epoch))
    entries = [{"SPDXID": "SPDXRef-stof", "name": "stof", "versionInfo": version, "downloadLocation": "NOASSERTION",
                "filesAnalyzed": False, "licenseConcluded": "Apache-2.0", "licenseDeclared": "Apache-2.0",
                "copyrightText": "NOASSERTION"}]
    relations = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": "SPDXRef-stof"}]
    for package in packages:
        name = _spdx_id(package.package)
        entries.append({
            "SPDXID": name, "name": package.name, "versionInfo": package.version, "downloadLocation": "NOASSERTION",
            "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator":
                              f"pkg:deb/{package.distribution}/{quote(package.source)}@{quote(package.version, safe='')}?arch=source"}],
            "filesAnalyzed": False, "licenseConcluded": "NOASSERTION", "licenseDeclared": "NOASSERTION",
            "copyrightText": "NOASSERTION", "comment": f"licences/{package.package}.txt",
            "sourceInfo": f"source package {package.source} {package.version}"})
        relations.append({"spdxElementId": "SPDXRef-stof", "relationshipType": "DEPENDS_ON", "relatedSpdxElement": name})
    digest = hashlib.sha256(json.dumps(entries, sort_keys=True).encode()).hexdigest()
    return json.dumps({
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": image,
        "documentNamespace": f"urn:stof:sbom:{digest}",
        "creationInfo": {"created": stamp, "creators": ["Tool: scripts/image"]},
        "packages": entries, "relationships": relations}, indent=1).encode() + b"\n"


def offer(version, packages, origin):
    lines = "\n".join(sorted({f"  {package.source} {package.version}" for package in packages}))
    return OFFER.format(home=HOME, version=version, origin=origin, lines=lines).encode()


def common_texts(packages):
    """{name: bytes} of the licences that copyright files refer to without their text."""
    names = {name.decode() for package in packages for name in REFERENCE.findall(package.licence)}
    for name in sorted(names):
        if not (COMMON / name).is_file():
            raise SbomError(f"{COMMON / name} is missing: install base-files of Debian")
    return {f"licences/common/{name}.txt": (COMMON / name).read_bytes() for name in sorted(names)}


def files(image, version, packages, licence, epoch, origin="Debian"):
    """{name on a slot: bytes}: the SBOM, the source offer, and the licence texts."""
    texts = {f"licences/{package.package}.txt": package.licence for package in packages}
    return {"sbom.spdx.json": document(image, version, packages, epoch), "sources.txt": offer(version, packages, origin),
            "licences/stof.txt": licence, **texts, **common_texts(packages)}
