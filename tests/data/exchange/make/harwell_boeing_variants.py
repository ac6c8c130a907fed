"""The matrices of variants.mtx and variants.mass.mtx in Harwell-Boeing files with every kind of format that programs write.

  python harwell_boeing_variants.py      needs NumPy and SciPy
Files that SciPy's hb_read understands are read by it and compared.
"""
import os
import numpy as np, scipy.io as sio, scipy.sparse as sp

HERE = os.path.dirname(os.path.abspath(__file__))


def out(*parts):
    return os.path.join(HERE, "..", *parts)


def fortran(width, digits, scale, letter):
    """1P (scale 1): d.ddd; else 0.ddd. A letter or none before the exponent."""

    def spell(value):
        mantissa, exponent = ("%.*e" % (digits if scale else digits - 1, value)).split("e")
        exponent = int(exponent)
        if not scale:
            sign, figures = ("-" if value < 0 else ""), mantissa.lstrip("-").replace(".", "")
            mantissa, exponent = f"{sign}0.{figures}", exponent + 1 if value else 0
        return f"{mantissa}{letter}{exponent:+03d}".rjust(width)

    return spell


def write(name, a, pointers, indices, values, per, title="", kind="RSA", right_hand=None, counts=5):
    """`per`: fields of a line and their width, for pointers, row numbers; fields of a line and a function for values."""
    a = (sp.tril(a) if kind[1] in "sS" else a).tocsc()
    a.sort_indices()
    n = a.shape[0]

    def lines(numbers, fields, spell):
        words = [spell(x) for x in numbers]
        return ["".join(words[i : i + fields]) for i in range(0, len(words), fields)]

    (pf, pw), (rf, rw), (vf, spell) = per
    p = lines(a.indptr + 1, pf, lambda x: "%*d" % (pw, x))
    r = lines(a.indices + 1, rf, lambda x: "%*d" % (rw, x))
    v = lines(a.data, vf, spell)
    b = lines(right_hand, vf, spell) if right_hand is not None else []
    sizes = [len(p) + len(r) + len(v) + len(b), len(p), len(r), len(v), len(b)][:counts]
    with open(out("ansys", name), "w", newline="\n") as f:
        f.write("%-72s%-8s\n" % (title, "KEY"))
        f.write("".join("%14d" % x for x in sizes) + "\n")
        f.write("%-3s%11s%14d%14d%14d%14d\n" % (kind, "", n, n, a.nnz, 0))
        f.write("%-16s%-16s%-20s%-20s\n" % (pointers, indices, values, values if b else ""))
        if b:
            f.write("%-14s%14d%14d\n" % ("F", 1, 0))
        f.write("\n".join(p + r + v + b) + "\n")
    return name


def check(name, like):
    """SciPy reads unsymmetric matrices without right-hand side and scale factor, split at blanks: the same numbers in such a file."""
    back = sio.hb_read(out("ansys", name)).tocsc()
    a = like.tocsc()
    back.sort_indices(), a.sort_indices()
    assert np.array_equal(back.indptr, a.indptr) and np.array_equal(back.indices, a.indices) and np.array_equal(back.data, a.data), name


k, m = (sio.mmread(out(name)).tocsr() for name in ("variants.mtx", "variants.mass.mtx"))
sio.hb_write(out("ansys", "variants_scipy.rua"), k.tocsc())
check("variants_scipy.rua", k)
check(write("variants_full.rua", k, "(10I8)", "(26I3)", "(3E25.17)", ((10, 8), (26, 3), (3, fortran(25, 17, 0, "E"))), kind="RUA"), k)
write("variants_fixed.rua", k, "(10I8)", "(10I8)", "(4F20.17)", ((10, 8), (10, 8), (4, lambda x: "%20.17f" % x)), kind="RUA")
write("variants_touching.rsa", k, "(10I8)", "(26I3)", "(1P,3E23.16)", ((10, 8), (26, 3), (3, fortran(23, 16, 1, "E"))), title="1 2 3.5")
write("variants_no_comma.rua", k, "(13I6)", "(13I6)", "(1P3E25.16E2)", ((13, 6), (13, 6), (3, fortran(25, 16, 1, "E"))), kind="RUA")
write("variants_d.rsa", k, "(4I20)", "(16I5)", "(4D25.17)", ((4, 20), (16, 5), (4, fortran(25, 17, 0, "D"))))
write("variants_no_letter.rsa", k, "(I14)", "(1I14)", "(1P,2E24.16)", ((1, 14), (1, 14), (2, fortran(24, 16, 1, ""))))
write(
    "variants_right_hand.rsa", m, "(10I8)", "(10I8)", "(3E25.17)", ((10, 8), (10, 8), (3, fortran(25, 17, 0, "E"))), right_hand=np.arange(12) / 3
)
write("variants_rutherford.rb", m, "(10I8)", "(10I8)", "(3E25.17)", ((10, 8), (10, 8), (3, fortran(25, 17, 0, "E"))), kind="rsa", counts=4)
