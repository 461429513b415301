"""What a power cut leaves of a folder, from the journal that storage_faults.cpp kept of the calls that changed it.

A file keeps the bytes of its last fsync, a folder the names of its last fsync. Of what came later a file system may
have written all, nothing or any part, so one cut has several outcomes:

  kept     all of it: as if all programs had been killed at once
  lost     nothing of it: the least that the calls promise
  renamed  all names, but no bytes: a file renamed before its bytes were written is empty or old
  torn     of each folder the first few changes, of each file any of its 512-byte sectors (by a seed)
"""

import os
import random
import struct

SECTOR = 512
HEAD = struct.Struct("<cQQIII")


class File:
    def __init__(self, data=b""):
        self.now = bytearray(data)
        self.durable = bytes(data)
        self.dirty = set()  # sectors written since the last fsync

    def write(self, offset, data):
        if len(self.now) < offset:
            self.resize(offset)
        self.now[offset:offset + len(data)] = data
        self.dirty.update(range(offset // SECTOR, (offset + len(data) - 1) // SECTOR + 1))

    def resize(self, size):
        before = len(self.now)
        del self.now[size:]
        self.now.extend(bytes(size - len(self.now)))
        self.dirty.update(range(min(before, size) // SECTOR, max(before, size) // SECTOR + 1))

    def sync(self):
        self.durable = bytes(self.now)
        self.dirty.clear()

    def after(self, outcome, dice):
        if outcome == "kept":
            return bytes(self.now)
        if outcome != "torn" or not self.dirty:
            return self.durable
        if dice.random() < 0.2:
            return bytes(self.now)
        # The size is a change of its own: it may have been written before the bytes.
        size = len(self.now) if dice.random() < 0.7 else len(self.durable)
        left = bytearray(self.durable[:size])
        left.extend(bytes(size - len(left)))
        for sector in self.dirty:
            start = sector * SECTOR
            if dice.random() < 0.5 and start < size:
                piece = self.now[start:min(start + SECTOR, size)]
                left[start:start + len(piece)] = piece
        return bytes(left)


class Folder:
    def __init__(self):
        self.now = {}
        self.durable = {}
        self.changes = []  # since the last fsync: (name, node or None)

    def set(self, name, node):
        if node is None:
            self.now.pop(name, None)
        else:
            self.now[name] = node
        self.changes.append((name, node))

    def sync(self):
        self.durable = dict(self.now)
        self.changes.clear()

    def after(self, outcome, dice):
        if outcome == "lost":
            return self.durable
        if outcome in ("kept", "renamed"):
            return self.now
        left = dict(self.durable)
        for name, node in self.changes[:dice.randint(0, len(self.changes))]:
            if node is None:
                left.pop(name, None)
            else:
                left[name] = node
        return left


class Record:
    def __init__(self, operation, inode, offset, path, second, data):
        self.operation, self.inode, self.offset = operation, inode, offset
        self.path, self.second, self.data = path, second, data


def read_journal(path):
    with open(path, "rb") as file:
        bytes_ = file.read()
    at, records = 0, []
    while at + HEAD.size <= len(bytes_):
        operation, inode, offset, *sizes = HEAD.unpack_from(bytes_, at)
        at += HEAD.size
        texts = []
        for size in sizes:
            texts.append(bytes_[at:at + size])
            at += size
        records.append(Record(operation.decode(), inode, offset, texts[0].decode(), texts[1].decode(), texts[2]))
    return records


def note(path, text):
    """Puts a remark between the records, e.g. that a caller was told something: N in place of an operation."""
    data = text.encode()
    with open(path, "ab", buffering=0) as file:
        file.write(HEAD.pack(b"N", 0, 0, 0, 0, len(data)) + data)


class Disk:
    """The folder as it is for the programs and as it would be after a power cut; begins empty."""

    def __init__(self, root):
        self.root = root.rstrip("/")
        self.top = Folder()
        self.files = {}  # inode -> File; numbers are used again only when their file is gone

    def _walk(self, path):
        relative = path[len(self.root):].strip("/")
        return relative.split("/") if relative else []

    def _folder(self, parts):
        folder = self.top
        for part in parts:
            folder = folder.now[part]
        return folder

    def _place(self, path):
        *parents, name = self._walk(path)
        return self._folder(parents), name

    def _file(self, record):
        """The file of a descriptor, or the one at the path if the opening was not seen."""
        if record.inode not in self.files:
            folder, name = self._place(record.path)
            if name not in folder.now:
                folder.set(name, File())
            self.files[record.inode] = folder.now[name]
        return self.files[record.inode]

    def apply(self, record):
        operation = record.operation
        if operation == "N":
            return
        if operation == "C":
            folder, name = self._place(record.path)
            self.files[record.inode] = File()
            folder.set(name, self.files[record.inode])
        elif operation == "W":
            self._file(record).write(record.offset, record.data)
        elif operation == "T":
            self._file(record).resize(record.offset)
        elif operation == "S":
            self._file(record).sync()
        elif operation == "D":
            self._folder(self._walk(record.path)).sync()
        elif operation in "RL":
            folder, name = self._place(record.path)
            target, target_name = self._place(record.second)
            target.set(target_name, folder.now[name])
            if operation == "R":
                folder.set(name, None)
        elif operation in "UX":
            folder, name = self._place(record.path)
            folder.set(name, None)
        elif operation == "M":
            folder, name = self._place(record.path)
            folder.set(name, Folder())
        else:
            raise ValueError(f"unknown operation {operation}")

    def after_cut(self, outcome, seed=0):
        """What the cut leaves: {path: bytes, or None for a folder}."""
        dice = random.Random(seed)
        left = {}

        def look(folder, prefix):
            for name, node in sorted(folder.after(outcome, dice).items()):
                if isinstance(node, Folder):
                    left[prefix + name] = None
                    look(node, prefix + name + "/")
                else:
                    left[prefix + name] = node.after(outcome, dice)

        look(self.top, "")
        return left


def write_tree(tree, target):
    os.makedirs(target)
    for path, data in tree.items():
        whole = os.path.join(target, path)
        if data is None:
            os.mkdir(whole)
        else:
            with open(whole, "wb") as file:
                file.write(data)
