"""Ground that is not flat in the picture: what a page is sent of it (`content`); `assets/terrain.js` draws it.

May import: core, results, scene.
To add: what else a page shows of tiles, such as their patches.
"""
