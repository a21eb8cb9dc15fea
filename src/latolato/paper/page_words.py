"""The words of the report's page in Indonesian: its frame, not what it says about the paper.

The page holds both languages and shows one of them: Indonesian while its address names an anchor
that begins with ``id-``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from markupsafe import Markup

from latolato.app.languages import language_of
from latolato.core.language import ENGLISH

CLAIMS_NOTE = (
    "A claim is reproduced if all its limits hold for the printed parameters. It is reproduced "
    "with an assumption if they hold once something unprinted is assumed, and not as printed "
    "otherwise. Where the paper prints too little to test its claim, we check only the method, on "
    "synthetic data or by calculation; such a check says nothing about the paper's measurements. "
    "✓ marks limits that hold, ✗ limits that fail."
)

INDONESIAN = {
    "Back to the toy": "Kembali ke mainan",
    "Parametric resonance of the Lato Lato 2.0, recalculated": (
        "Resonansi parametrik Lato Lato 2.0, dihitung ulang"
    ),
    "A quick run: some scans have fewer points.": (
        "Perhitungan cepat: sebagian pemindaian memiliki lebih sedikit titik."
    ),
    "A full run.": "Perhitungan lengkap.",
    "SI units; angles from the downward vertical; g = 9.8 m/s² as in the paper.": (
        "Satuan SI; sudut dihitung dari arah tegak ke bawah; g = 9,8 m/s² seperti dalam makalah."
    ),
    "reproduced": "tereproduksi",
    "reproduced with an assumption": "tereproduksi dengan pengandaian",
    "not as printed": "tidak seperti tercetak",
    "method check, not testable from the paper": (
        "pemeriksaan metode, tidak dapat diuji dari makalah"
    ),
    "Claims": "Pernyataan",
    "Still open": "Belum terjawab",
    "Figures": "Gambar",
    "Beyond the paper": "Di luar makalah",
    "Errata": "Ralat",
    "Method": "Metode",
    "Compute again": "Hitung lagi",
    "Cite": "Kutip",
    "Verdict": "Penilaian",
    "The paper's words": "Kata-kata makalah",
    "What we find": "Yang kami temukan",
    "Why": "Alasannya",
    "Assumed:": "Diandaikan:",
    "Checked:": "Diperiksa:",
    "Claims:": "Pernyataan:",
    "none": "tidak ada",
    "Open in Toy": "Buka di Mainan",
    "Open in Map": "Buka di Peta",
    "Runs behind it": "Simulasi di baliknya",
    "Sweeps behind it": "Pemindaian di baliknya",
    "open in Toy": "buka di Mainan",
    "open in Map": "buka di Peta",
    # Cases of the paper.
    "resonant": "beresonansi",
    "quiet": "tenang",
    "twice": "dua kali lipat",
    "undamped": "tanpa redaman",
    "damped": "dengan redaman",
    "strong rest": "kuat, dari keadaan diam",
    "strong push": "kuat, dengan dorongan",
    "strong coarse": "kuat, langkah kasar",
    "strong fine": "kuat, langkah halus",
    "weak rest": "lemah, dari keadaan diam",
    "weak push": "lemah, dengan dorongan",
    "weak coarse": "lemah, langkah kasar",
    "weak fine": "lemah, langkah halus",
    "free": "bebas",
    "pushed": "didorong",
    "short": "pendek",
    "the motion that was filmed": "gerak yang direkam",
    "single": "satu bola",
    "amplitudes": "amplitudo",
    "starts": "keadaan awal",
    "coupled": "dua bola",
    "cosine": "kosinus",
    "crank": "engkol",
    "settled": "menetap",
    "rods": "batang",
    "rods rest": "batang, dari keadaan diam",
    "rods push": "batang, dengan dorongan",
    "strings rest": "tali, dari keadaan diam",
    "strings push": "tali, dengan dorongan",
    "harmonic": "harmonik",
    "crank slider": "engkol dan peluncur",
    "frequency schedule": "frekuensi bertahap",
    # Parameters without a name on the pages.
    "followed along": "diikuti sepanjang",
    "Parameters": "Parameter",
    "parameter": "parameter",
    "value": "nilai",
    "Files beside this page:": "Berkas di samping halaman ini:",
    "Left to experiments and further analysis, not yet in this report": (
        "Menunggu percobaan dan analisis lebih lanjut, belum ada dalam laporan ini"
    ),
    "Left out of this report:": "Tidak termasuk dalam laporan ini:",
    "Needs": "Memerlukan",
    "Links in the captions open the runs in the pages beside this report, which "
    "latolato app --report FOLDER and latolato site serve together with it.": (
        "Tautan dalam keterangan gambar membuka simulasinya di halaman di samping laporan ini, "
        "yang disajikan bersamanya oleh latolato app --report FOLDER dan latolato site."
    ),
    "How it was computed": "Cara menghitungnya",
    "part": "bagian",
    "exact runs": "simulasi tepat",
    "tolerance [rad]": "toleransi [rad]",
    "step [ms]": "langkah [ms]",
    "contacts": "kontak",
    "worst residual": "residu terburuk",
    "sweep": "pemindaian",
    "runs": "simulasi",
    "duration [s]": "durasi [s]",
    "without an answer": "tanpa hasil",
    "Warnings of the runs:": "Peringatan dari simulasi:",
    "How to compute it again": "Cara menghitungnya lagi",
    "The whole report, then one figure:": "Seluruh laporan, lalu satu gambar:",
    "Each data file contains the scenario of each run as JSON: system, drive, start. The files of "
    "maps contain the plan of each sweep.": (
        "Setiap berkas data memuat skenario tiap simulasi sebagai JSON: sistem, penggerak, keadaan "
        "awal. Berkas peta memuat rencana tiap pemindaian."
    ),
    "How to cite": "Cara mengutip",
    "This file is self-contained; the pictures and data next to it are for further use.": (
        "Berkas ini lengkap dengan sendirinya; gambar dan data di sampingnya untuk dipakai lebih "
        "lanjut."
    ),
    CLAIMS_NOTE: (
        "Sebuah pernyataan tereproduksi jika semua batasnya terpenuhi dengan parameter yang "
        "tercetak. Pernyataan itu tereproduksi dengan pengandaian jika batasnya terpenuhi setelah "
        "sesuatu yang tidak tercetak diandaikan, dan selain itu tidak seperti tercetak. Bila yang "
        "tercetak terlalu sedikit untuk menguji pernyataan, kami hanya memeriksa metodenya, dengan "
        "data buatan atau perhitungan; pemeriksaan seperti itu tidak mengatakan apa-apa tentang "
        "pengukuran dalam makalah. ✓ menandai batas yang terpenuhi, ✗ batas yang tidak."
    ),
}
# What the pages call laws and parameters is called so here as well.
_PAGES = language_of("id")
LANGUAGES = {"en": ENGLISH, "id": replace(_PAGES, texts={**_PAGES.texts, **INDONESIAN})}
# Stands on the page in Indonesian alone.
ENGLISH_PARTS = (
    "Pengantar, pernyataan makalah, temuan, metode, dan keterangan gambar berbahasa Inggris, "
    "seperti makalahnya."
)


def words(text: str, set_text: Callable[[str], str]) -> Markup:
    """Return a text of the page in both languages, as it is where it has no Indonesian."""
    indonesian = LANGUAGES["id"].texts.get(text)
    if indonesian is None:
        return Markup(set_text(text))
    return Markup(
        f'<span class="en">{set_text(text)}</span>'
        f'<span class="id" lang="id">{set_text(indonesian)}</span>'
    )


def link(target: str, text: str, set_text: Callable[[str], str]) -> Markup:
    """Return a link to a part of the page, which stays in its language."""
    return Markup(
        f'<a class="en" href="#{target}">{set_text(text)}</a>'
        f'<a class="id" href="#id-{target}">{set_text(INDONESIAN.get(text, text))}</a>'
    )
