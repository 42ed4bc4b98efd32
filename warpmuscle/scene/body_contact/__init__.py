"""Contact of bodies with each other: what a scene says of it (`part`), and which bodies may touch (`pairs`).

May import: scene.
To add: a number to `BodyContact`, its check into `scene.validation.contact`; `contact/body_contact.py` has the force.
"""
