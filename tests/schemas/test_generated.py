"""The committed generated files say what schema.usda says, and schema.usda says what tokens.py says."""

import json
from importlib.util import find_spec
from pathlib import Path

import pytest
from pxr import Sdf

from tools.make_schemas import GENERATED, generate
from usdfoot.bridge import tokens
from usdfoot.model.motion import STATUSES

INSTANCE = "__INSTANCE_NAME__"


def schema_properties(folder: Path) -> dict[str, dict[str, tuple]]:
    """By schema and property name: type, variability, fallback and allowed tokens."""
    layer = Sdf.Layer.FindOrOpen(str(folder / "generatedSchema.usda"))
    return {
        schema.name: {
            name: (
                str(getattr(spec, "typeName", "rel")),
                spec.variability,
                getattr(spec, "default", None),
                tuple(getattr(spec, "allowedTokens", None) or ()),
            )
            for name, spec in schema.properties.items()
        }
        for schema in layer.rootPrims
        if schema.properties
    }


def plugin_types(folder: Path) -> dict:
    lines = (folder / "plugInfo.json").read_text(encoding="utf-8").splitlines()
    (plugin,) = json.loads("\n".join(line for line in lines if not line.startswith("#")))["Plugins"]
    assert plugin["Name"] == tokens.PLUGIN
    assert (plugin["Type"], plugin["Root"], plugin["ResourcePath"], plugin["LibraryPath"]) == ("resource", ".", ".", "")
    return plugin["Info"]["Types"]


@pytest.fixture(scope="module")
def committed(repository: Path) -> Path:
    return repository / "schemas"


@pytest.mark.skipif(find_spec("pxr.Usd.usdGenSchema") is None, reason="this build of USD ships without usdGenSchema")
def test_regenerating_gives_what_is_committed(committed, tmp_path):
    generate(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == set(GENERATED)
    assert schema_properties(tmp_path) == schema_properties(committed)
    assert plugin_types(tmp_path) == plugin_types(committed)


def test_a_broken_schema_is_reported_and_nothing_replaced(tmp_path, monkeypatch):
    (tmp_path / "schema.usda").write_text("#usda 1.0\n(\n", encoding="utf-8")
    monkeypatch.setattr("tools.make_schemas.SCHEMAS", tmp_path)
    with pytest.raises(RuntimeError, match="usdGenSchema"):
        generate(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["schema.usda"]


def token_values(namespace: type) -> set[str]:
    """All names of one class of tokens.py, both feet's."""
    values = (value for name, value in vars(namespace).items() if name.isupper())
    return {name for value in values for name in ((value,) if isinstance(value, str) else value)}


def test_tokens_and_schemas_name_the_same_schemas(committed):
    declared = {info["schemaIdentifier"] for info in plugin_types(committed).values()}
    assert token_values(tokens.Schema) == declared | set(tokens.Schema.CONTACT_INSTANCES)


def test_every_type_has_the_alias_by_which_older_usd_finds_it(committed):
    for info in plugin_types(committed).values():
        assert info["alias"] == {"UsdSchemaBase": info["schemaIdentifier"]}


@pytest.mark.parametrize(
    ("schema", "namespace"),
    [
        (tokens.Schema.BIPED, tokens.Biped),
        (tokens.Schema.CLIP, tokens.Clip),
        (tokens.Schema.PLAN, tokens.Plan),
        (tokens.Schema.PATH, tokens.Path),
        (tokens.Schema.TERRAIN, tokens.Terrain),
        (tokens.Schema.OBSTACLE, tokens.Obstacle),
        (tokens.Schema.AGENT, tokens.Agent),
        (tokens.Schema.RESULT, tokens.Result),
        (tokens.Schema.CONTACT, tokens.Contact),
    ],
)
def test_tokens_and_schemas_name_the_same_properties(committed, schema, namespace):
    declared = schema_properties(committed)[schema]
    expanded = {name.replace(INSTANCE, side) for name in declared for side in tokens.SIDES}
    assert token_values(namespace) == expanded


@pytest.mark.parametrize(
    ("schema", "name", "allowed"),
    [
        (tokens.Schema.CLIP, tokens.Clip.ROOT_MOTION, tokens.RootMotion.ALL),
        (tokens.Schema.AGENT, tokens.Agent.MOTION, tokens.Motion.ALL),
        (tokens.Schema.RESULT, tokens.Result.STATUS, STATUSES),
    ],
)
def test_allowed_tokens_are_those_of_the_code(committed, schema, name, allowed):
    *_, declared = schema_properties(committed)[schema][name]
    assert declared == allowed


def test_the_core_and_the_contract_agree_on_the_statuses():
    assert tokens.Status.ALL == STATUSES
    assert set(tokens.Status.PLACED) < set(STATUSES)


def test_everything_but_relationships_is_uniform(committed):
    varying = [
        name
        for properties in schema_properties(committed).values()
        for name, (type_name, variability, *_) in properties.items()
        if type_name != "rel" and variability != Sdf.VariabilityUniform
    ]
    assert varying == []


def test_fallbacks_are_those_of_the_contract(committed):
    fallbacks = {
        name: default
        for properties in schema_properties(committed).values()
        for name, (_, _, default, _) in properties.items()
        if default is not None
    }
    assert fallbacks == {
        tokens.Clip.STYLE: "default",
        tokens.Clip.ROOT_MOTION: "auto",
        tokens.Clip.MIRROR: True,
        tokens.Clip.SOURCE: "recorded",
        tokens.Path.SPEED: 0.0,
        tokens.Path.STEP_LENGTH: 0.0,
        tokens.Path.STEP_WIDTH: 0.0,
        tokens.Terrain.WALKABLE: True,
        tokens.Obstacle.MARGIN: 0.0,
        tokens.Agent.SPEED: 0.0,
        tokens.Agent.MOTION: "clips",
        tokens.Agent.ROOT_WEIGHT: 0.0,
        tokens.Agent.HIP_SPACING: 1.0,
        tokens.Agent.CROUCH: 0.0,
        tokens.Agent.COM_SHIFT: (0.0, 0.0, 0.0),
        tokens.Agent.PITCH: 1.0,
        tokens.Agent.SWAY: 1.0,
    }


@pytest.mark.parametrize(
    "scene",
    [
        "scenes/walk_flat.usda",
        "scenes/stepping_stones.usda",
        "scenes/crowd_zara.usda",
        "bandai/bandai_clips.usdc",
        "cmu/cmu_character.usdc",
    ],
)
def test_real_scenes_author_the_properties_as_declared(committed, shared_data, scene):
    declared = {name: spec for specs in schema_properties(committed).values() for name, spec in specs.items()}
    layer = Sdf.Layer.FindOrOpen(str(shared_data / scene))
    found: list[str] = []

    def collect(path: Sdf.Path) -> None:
        if path.IsPropertyPath() and path.name.startswith("usdfoot:"):
            found.append(path.name)
            spec = layer.GetPropertyAtPath(path)
            assert (str(getattr(spec, "typeName", "rel")), spec.variability) == declared[path.name][:2], path

    layer.Traverse(Sdf.Path.absoluteRootPath, collect)
    assert found
