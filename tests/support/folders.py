"""Contents of a folder, to be compared with those before."""


def contents_of(folder):
    """Bytes of every file below a folder: {name: bytes}, names with slashes."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }
