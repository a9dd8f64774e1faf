"""Parts of the generator of `stages/`: a person, a walker that moves it, terrains, courses and the USD they become.

Nothing here is part of the usdfoot package, and nothing here imports it: the generator is the independent known truth.
"""
