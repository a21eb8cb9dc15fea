"""Spreadsheets and archives, written without another package."""

import io
import zipfile


def zipped(**members):
    """Return the bytes of an archive of these members; __ in a name stands for a slash."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        for name, text in members.items():
            archive.writestr(name.replace("__", "/"), text)
    return memory.getvalue()


def sheet_xml(rows):
    """Return the XML of a sheet of numbers and texts."""
    cells = [
        "".join(
            f"<c><v>{cell!r}</v></c>"
            if isinstance(cell, float)
            else f'<c t="inlineStr"><is><t>{cell}</t></is></c>'
            for cell in row
        )
        for row in rows
    ]
    space = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    body = "".join(f"<row>{each}</row>" for each in cells)
    return f'<worksheet xmlns="{space}"><sheetData>{body}</sheetData></worksheet>'


def workbook(**sheets):
    """Return the bytes of an .xlsx with these sheets."""
    main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    relations = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
    package = "http://schemas.openxmlformats.org/package/2006/relationships"
    listed = "".join(
        f'<sheet name="{name}" sheetId="{i}" r:id="r{i}"/>' for i, name in enumerate(sheets, 1)
    )
    links = "".join(
        f'<Relationship Id="r{i}" Type="{relations}/worksheet" Target="worksheets/s{i}.xml"/>'
        for i in range(1, len(sheets) + 1)
    )
    parts = {
        "xl/workbook.xml": f'<workbook xmlns="{main}" xmlns:r="{relations}">'
        f"<sheets>{listed}</sheets></workbook>",
        "xl/_rels/workbook.xml.rels": f'<Relationships xmlns="{package}">{links}</Relationships>',
        "_rels/.rels": f'<Relationships xmlns="{package}"><Relationship Id="r0" '
        f'Type="{relations}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        "[Content_Types].xml": '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"/>',
    }
    parts |= {
        f"xl/worksheets/s{i}.xml": sheet_xml(rows) for i, rows in enumerate(sheets.values(), 1)
    }
    return zipped(**parts)
