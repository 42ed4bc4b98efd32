"""From a model with two legs to a scene in which it learns to walk.

Feet are found and get soles, what no muscle moves is held by springs, and a task says what is learnt.

May import: formats and all below.

To add: what a walk needs of a body to a file here, and to the text of `task`.
"""
