# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tiles of the user's MBTiles file: rows counted from the other side, and wrong files."""

from __future__ import annotations

import asyncio
import sqlite3

import pytest
import tornado.httpclient

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.view.page import tile_routes
from aerial_gnss_ros.view.server import LOCAL, application, listen
from aerial_gnss_ros.view.tiles import Tiles

NORTH_WEST = (1, 0, 1)  # zoom, column, row from the south


def mbtiles(path, tiles=(NORTH_WEST,), kind="png", **about):
    with sqlite3.connect(path) as file:
        file.execute("create table metadata (name text, value text)")
        file.execute(
            "create table tiles (zoom_level integer, tile_column integer, tile_row integer, "
            "tile_data blob)"
        )
        file.executemany(
            "insert into metadata values (?, ?)", {"format": kind, "name": "sea", **about}.items()
        )
        file.executemany(
            "insert into tiles values (?, ?, ?, ?)", [(*one, repr(one).encode()) for one in tiles]
        )
    file.close()
    return path


def test_pages_count_rows_from_the_north(tmp_path):
    tiles = Tiles(mbtiles(tmp_path / "sea.mbtiles"))
    assert tiles.tile(1, 0, 0) == repr(NORTH_WEST).encode()
    assert tiles.tile(1, 0, 1) is None
    assert (tiles.tile(1, 0, 2), tiles.tile(99, 0, 0)) == (None, None)
    assert tiles.type == "image/png"


def test_levels_and_attribution_are_the_files_own(tmp_path):
    path = mbtiles(tmp_path / "a", [(3, 0, 0), (9, 1, 1)], "jpg", attribution="© somebody")
    described = Tiles(path).description()
    assert described == {"lowest": 3, "highest": 9, "attribution": "© somebody"}
    assert Tiles(path).type == "image/jpeg"


def test_the_file_is_opened_for_reading_only(tmp_path):
    path = mbtiles(tmp_path / "sea.mbtiles")
    path.chmod(0o444)
    before = path.read_bytes()
    Tiles(path).tile(1, 0, 0)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_the_page_gets_tiles_and_nothing_where_there_is_none(tmp_path):
    tiles = Tiles(mbtiles(tmp_path / "sea.mbtiles"))

    async def task():
        server, url = listen(application("view.html", tile_routes(tiles)), LOCAL, 0)
        client = tornado.httpclient.AsyncHTTPClient(force_instance=True)
        paths = ("tiles/1/0/0", "tiles/1/1/1", "tiles/1/0/x")
        try:
            return [await client.fetch(url + path, raise_error=False) for path in paths]
        finally:
            server.stop()
            await server.close_all_connections()

    found, none, wrong = asyncio.run(task())
    assert (found.body, found.headers["Content-Type"]) == (repr(NORTH_WEST).encode(), "image/png")
    assert (none.code, none.body, wrong.code) == (204, b"", 404)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda _path: None, "there is no .*; --tiles takes an MBTiles file"),
        (lambda path: path.write_bytes(b"no database" * 99), "is no MBTiles file .*raster tiles"),
        (lambda path: path.write_bytes(b""), "is no MBTiles file"),
        (lambda path: mbtiles(path, kind="pbf"), "tiles of format pbf; the page draws png"),
        (lambda path: mbtiles(path, ()), "holds no tiles"),
        (lambda path: mbtiles(path, [(40, 0, 0)]), "zoom levels 40 to 40, not 0 to 24"),
    ],
    ids=["missing", "no database", "empty", "vector tiles", "no tiles", "zoom"],
)
def test_a_wrong_file_is_refused_in_one_sentence(tmp_path, make, words):
    path = tmp_path / "sea.mbtiles"
    make(path)
    with pytest.raises(InputError, match=words) as caught:
        Tiles(path)
    assert "\n" not in str(caught.value)
