# SPDX-License-Identifier: Apache-2.0
"""Makes the report of ./paint accuracy from the measurements of tests/benchmark/trade."""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Callable, Iterator
from pathlib import Path

from common import bars
from common.processes import run_program, say
from common.report_folder import ACCURACY, REPORT, table

from accuracy import plots
from accuracy.results import (
    DEPTH_MODELS,
    DRAW,
    EXACT,
    FLAKE_SIZE,
    NOT_JUDGED,
    TOGETHER,
    Choice,
    Results,
    Traced,
    fluctuation,
)

NEARLY_AS_BRIGHT = 0.1  # what the eye hardly tells from one picture to the next
SCREEN_STEP = 1 / 255  # of an 8-bit picture
# What the mean of “correlated” may be off by. The first where flakes are at most as wide as the
# layer is thick: wider ones stick out of it.
MEAN_OFF, MEAN_OFF_WIDE = 0.03, 0.06
SQUARE_OFF = 0.03  # and its mean square, likewise for the narrower ones
CHANCE = 1e-4  # that one of the cases misses by the tracing's noise alone
NUMBER_TYPE, ORIENTATION = "number type", "orientation P(β)"
# What the numbers alone do not say.
NOTES = {
    NUMBER_TYPE: "The shader computes in float and has no other; this is for callers of the C++.",
    ORIENTATION: "Tables are the paper's way, with P at the centre of the cone of normals; "
    "for callers of the C++, the shader carries none.",
    "blocked area ⟨s⟩ − ⟨t⟩": "A constant transmittance leaves a closed form. Only Gaussian "
    "flakes tilted by more than 0.4 and seen from their backs take 12 points in float.",
    DRAW: "What its law errs is in the table of the draw's law.",
    "radiometry": "“Published” is the paper to the letter: not another price but another mean.",
    "depth": "Which of them is right is not a matter of this table: see the traced flakes.",
    "flake spread ε": "A number of the paint, no approximation: shown for what it does.",
    TOGETHER: "What ships against everything exact; the draws' noise is in the distribution.",
}


def number(value: float) -> str:
    if value == 0:
        return "0"
    if value < EXACT:
        return "< 6e-8"
    return f"{value:.2g}".replace("e-0", "e-").replace("e+0", "e")


def times(ratio: float) -> str:
    if ratio >= 1.5:
        return f"× {ratio:.1f}" if ratio < 20 else f"× {ratio:,.0f}"
    return f"{round(100 * (ratio - 1)):+d} %".replace("-", "−")


def percent(part: float, digits: int = 0) -> str:
    return f"{part:.{digits}%}".replace("%", " %")


def verdict(choice: Choice) -> str:
    if choice.dominated_by:
        return f"dominated by {choice.dominated_by}"
    return "front"


def trade_of(choice: Choice) -> str:
    """A choice on the front beside what ships."""
    error = "no error" if choice.error <= EXACT else f"error {number(choice.error)} σ"
    return f"{choice.name} ({times(choice.time)} time, {error})"


def sentence(results: Results, group: str) -> str:
    """What ships in a group, and what there is besides."""
    choices, shipped = results.of(group), results.shipped(group)
    error = f" (error {number(shipped.error)} σ)" if shipped.error > EXACT else ""
    text = f"**{group}**: ships *{shipped.name}*{error}, "
    if shipped.dominated_by:
        text += f"**dominated by {shipped.dominated_by}**."
    else:
        text += "on the front."
    front = [c for c in choices if not c.dominated_by and not c.shipped]
    faster = [c for c in front if c.time < shipped.time]
    finer = [c for c in front if c not in faster]
    dominated = [c.name for c in choices if c.dominated_by and not c.shipped]
    for what, some in (("Faster", faster), ("Finer", finer)):
        if some:
            text += f" {what}: {'; '.join(trade_of(c) for c in some)}."
    if dominated:
        text += f" Dominated: {', '.join(dominated)}."
    return text


def judged(results: Results) -> list[str]:
    return [group for group in results.groups if group not in NOT_JUDGED]


def worst_flip(results: Results, choice: Choice) -> str:
    scene = max(choice.flip, key=choice.flip.__getitem__)
    text = number(choice.flip[scene])
    if choice.numbers != "same":
        text += f" ({number(results.floor_flip[scene][choice.numbers])})"
    return text


def mean_over_traced(case: dict, model: str) -> float:
    return case[model]["mean"] / case["traced"]["mean"]


def fluctuation_over_traced(case: dict, model: str) -> float:
    return fluctuation(case[model]) / fluctuation(case["traced"])


def over_traced(results: Results, model: str, quantity: Callable[[dict, str], float]) -> str:
    """The range of a model's quantity, over the traced one, in all cases."""
    cases = results.data["explicit"]
    parts = [quantity(case, model) for case in cases]
    least = cases[parts.index(min(parts))]
    return (
        f"{percent(min(parts))} (at {least['varied']} {least['value']:g}) to {percent(max(parts))}"
    )


def paper_nearer(results: Results) -> int:
    """In how many cases a law of the paper's is nearer than correlated's by more than the noise."""
    ours, *papers = DEPTH_MODELS
    distances = [case["distance"] for case in results.data["explicit"]]
    return sum(min(d[m] for m in papers) + d["floor"] < d[ours] for d in distances)


def depth_models(results: Results) -> Iterator[str]:
    distances = [case["distance"] for case in results.data["explicit"]]
    nearest = sum(d["correlated"] == min(d[m] for m in DEPTH_MODELS) for d in distances)
    means, fluctuations = (
        {model: over_traced(results, model, quantity) for model in DEPTH_MODELS}
        for quantity in (mean_over_traced, fluctuation_over_traced)
    )
    yield (
        "- Against flakes traced one by one, each hiding others, the mean of “correlated” is "
        f"{means['correlated']} of the traced one. The mean that “attenuated” and “thinned” share "
        f"is {means['attenuated']}: what hides a flake from the observer often hides it from the "
        "light as well, where these two take both for independent."
    )
    yield (
        f"- As a whole law (Wasserstein) “correlated” is the nearest of the three in {nearest} of "
        f"{len(distances)} cases; in {paper_nearer(results)} of them another is nearer by "
        "more than the noise. The fluctuation E[s²]/E[s]² of “correlated” is "
        f"{fluctuations['correlated']} of the traced one, of “attenuated” "
        f"{fluctuations['attenuated']}, of “thinned” {fluctuations['thinned']}. “Attenuated” dims "
        "all flakes at one depth alike; of traced ones chance hides some, and parts of others."
    )


def explicit_time(results: Results) -> float:
    """Of a pixel of the nearest scene with each flake traced, of what ships."""
    scene = results.data["traced"]["scene"]
    return results.traced.nanoseconds / results.shipped(TOGETHER).nanoseconds[scene]


def in_short(results: Results) -> Iterator[str]:
    shipped = results.shipped(TOGETHER)
    exact = next(c for c in results.of(TOGETHER) if c.exact)
    worst = max(results.scenes, key=lambda s: shipped.flip[s] / results.floor_flip[s]["own"])
    dominated = [group for group in judged(results) if results.shipped(group).dominated_by]
    yield "## In short"
    yield ""
    if dominated:
        yield f"- **What ships is off the front in: {', '.join(dominated)}.**"
    else:
        yield (
            "- Leave everything as it ships: no other choice is both as fast and as exact (but for "
            "the number type, which the shader fixes)."
        )
    low, high = (f(shipped.nanoseconds.values()) for f in (min, max))
    share = shipped.flip[worst] / results.floor_flip[worst]["own"]
    yield (
        f"- What ships draws a pixel in {low:.0f} to {high:.0f} ns on one core, {exact.time:.1f} "
        f"times as fast as everything exact in double. Its pictures' FLIP from the exact ones is "
        f"at most {number(max(shipped.flip.values()))}: at most {share:.0%} of that between two "
        f"exact pictures of different seeds (scene “{worst}”)."
    )
    for group in [*judged(results), NUMBER_TYPE]:
        note = f" {NOTES[group]}" if group in NOTES else ""
        if group == ORIENTATION and "lamp" in results.scenes:
            note += f" {centre_under_the_lamp(results)}"
        yield f"- {sentence(results, group)}{note}"
    yield from depth_models(results)
    yield f"- {brightness_advice(results)}"
    traced, far = results.traced, results.scenes["far"]
    others, apart, own = (flip for flip, _ in traced.compared.values())
    yield (
        f"- Tracing every flake, the far end, takes {explicit_time(results):,.0f} times as long "
        f"near ({1e-6 * traced.nanoseconds:.1f} ms a pixel); far, a pixel has "
        f"{far['flakes']:,.0f} flakes. The traced picture's mean is {brightness(traced)} of the "
        f"model's; its FLIP from what ships is {number(apart)}, between two seeds "
        f"{number(others)} (of what ships: {number(own)})."
    )
    yield ""


def share_off(
    results: Results, quantity: str = "mean", *, beyond_chance: bool = False
) -> tuple[list[float], list[float]]:
    """What the mean, or "square", of “correlated” is off by: of flakes at most as wide as the layer
    is thick, and of wider ones.
    """
    cases = results.data["explicit"]
    z = statistics.NormalDist().inv_cdf(1 - CHANCE / (2 * len(cases))) if beyond_chance else 0
    found: tuple[list[float], list[float]] = ([], [])
    for case in cases:
        noise = z * case[f"deviation_of_{quantity}"] / case["traced"][quantity]
        off = abs(case["correlated"][quantity] / case["traced"][quantity] - 1)
        wide = case["varied"] == FLAKE_SIZE and case["value"] > 1
        found[wide].append(max(off - noise, 0))
    return found


def centre_under_the_lamp(results: Results) -> str:
    finest = results.of(ORIENTATION)[-1]
    sun = max(e["distribution"] for scene, e in finest.errors.items() if scene != "lamp")
    lamp = finest.errors["lamp"]
    return (
        f"P {finest.name}, errs {number(sun)} σ at most under the sun; under “lamp”, as wide as "
        f"the tilt, {number(lamp['distribution'])} σ and {lamp['mean']:.1%} of the mean, in "
        f"{times(finest.ratios['lamp'])} time."
    )


def brightness(traced: Traced) -> str:
    return f"{100 * traced.brightness:.0f} ± {percent(traced.brightness_error)}"


def brightness_advice(results: Results) -> str:
    """How much brighter traced flakes are than the paper's models, and where it matters not."""
    excess: dict[str, dict[float, float]] = {}
    for case in results.data["explicit"]:
        ratio = case["traced"]["mean"] / case["attenuated"]["mean"]
        excess.setdefault(case["varied"], {})[case["value"]] = ratio - 1
    coverage, angle, size, *_ = excess.values()
    narrow, wide = share_off(results)
    densest, steep, grazing = max(coverage), min(angle), max(angle)
    least_cover, least_size = (
        max((v for v, more in of.items() if more <= NEARLY_AS_BRIGHT), default=0)
        for of in (coverage, size)
    )
    return (
        "**Brightness**: dense layers of large flakes are up to "
        f"{percent(coverage[densest])} brighter than “attenuated” and “thinned” when light and "
        f"observer are near the paint's normal (coverage {densest:g}, 20°); at coverage 0.5 "
        f"{percent(angle[steep])} at {steep:g}° to the normal and {percent(angle[grazing])} at "
        f"{grazing:g}°, {percent(size[max(size)])} for flakes {max(size):g} times as wide as the "
        f"layer is thick. These two are within {percent(NEARLY_AS_BRIGHT)} up to coverage "
        f"{least_cover:g}, or with flakes of at most {least_size:g} of the layer's thickness. The "
        f"mean of “correlated” is off by {percent(max(narrow), 1)} at most where flakes are at "
        f"most as wide as the layer is thick, by {percent(max(wide), 1)} at most where they are "
        f"wider; its mean square by {percent(max(share_off(results, 'square')[0]), 1)} and "
        f"{percent(max(share_off(results, 'square')[1]), 1)}."
    )


def scene_table(results: Results) -> Iterator[str]:
    shipped = results.shipped(TOGETHER)
    rows = []
    for name, scene in results.scenes.items():
        flip = results.floor_flip[name]
        rows.append([
            name, f"{1e3 * scene['pixel']:g} mm", f"{scene['tilt']:g}",
            f"{scene['sparkles']:,.3g}", f"{scene['flakes']:,.3g}",
            f"{shipped.nanoseconds[name]:.0f}", number(shipped.flip[name]), number(flip["counts"]),
            number(flip["own"]),
        ])  # fmt: skip
    yield from table(
        ["scene", "pixel", "tilt", "sparkles ⟨N⟩ in the brightest pixel", "its flakes",
         "ns a pixel, shipped", "FLIP shipped : exact", "FLIP exact : other sums",
         "FLIP exact : other seed"],
        rows,
    )  # fmt: skip


def choice_tables(results: Results) -> Iterator[str]:
    for group in results.groups:
        yield f"### {group[0].upper()}{group[1:]}"
        yield ""
        if group in NOTES:
            yield f"{NOTES[group]}"
            yield ""
        rows = []
        for c in results.of(group):
            name = f"**{c.name}**" if c.shipped else c.name
            rows.append([
                name, times(c.time),
                " / ".join(f"{ns:,.0f}" for ns in c.nanoseconds.values()),
                *(number(c.worst(error)) for error in ("count", "mean", "deviation")),
                number(c.error), worst_flip(results, c),
                number(max(c.rmse.values())), "" if group in NOT_JUDGED[1:] else verdict(c),
            ])  # fmt: skip
        scenes = " / ".join(results.scenes)
        yield from table(
            ["choice", "time", f"ns {scenes}", "count", "mean", "deviation", "distribution",
             "FLIP", "RMSE", ""],
            rows,
        )  # fmt: skip


def depth_table(results: Results) -> Iterator[str]:
    rows = []
    for case in results.data["explicit"]:
        fluctuations = [f"{fluctuation(case[m]):.3f}" for m in ("traced", *DEPTH_MODELS)]
        distances = [number(case["distance"][m]) for m in (*DEPTH_MODELS, "floor")]
        rows.append([
            f"{case['varied']} {case['value']:g}", f"{case['count']:.3f}",
            f"{case['traced']['mean']:.3f} ± {case['deviation_of_mean']:.3f}",
            f"{case['correlated']['mean']:.3f}", f"{case['attenuated']['mean']:.3f}",
            *fluctuations, *distances,
        ])  # fmt: skip
    yield from table(
        ["varied", "count, traced : model", "E[s] traced", "correlated", "attenuated and thinned",
         "E[s²]/E[s]² traced", *DEPTH_MODELS, "distance correlated", *DEPTH_MODELS[1:], "noise"],
        rows,
    )  # fmt: skip


def traced_tables(results: Results) -> Iterator[str]:
    data, traced = results.data["traced"], results.traced
    yield (
        f"The scene “{data['scene']}” at {data['size']} × {data['size']} pixels, every flake of "
        f"every pixel a disc among discs: {traced.nanoseconds:,.0f} ns a pixel, "
        f"{explicit_time(results):,.0f} times what ships takes. The "
        f"mean of the traced picture is {brightness(traced)} of the model's. Two pictures:"
    )
    yield ""
    rows = [[name, number(a), number(b)] for name, (a, b) in traced.compared.items()]
    yield from table(["pictures", "FLIP", "RMSE"], rows)
    yield (
        f"The law of a pixel, over {data['draws']} draws of each of {data['judged']} pixels, as "
        "in the tables below, but with traced flakes for the exact choice; the last line is noise. "
        "A flake that spreads part of the light to the observer counts as one when traced, which "
        "is why the counts differ:"
    )
    yield ""
    rows = [
        [
            f"**{choice.name}**" if choice.shipped else choice.name, f"{ns:,.0f}",
            *(number(e) for e in errors.values()),
        ]
        for choice, ns, errors in traced.choices
    ]  # fmt: skip
    noise = [number(e) for e in data["floor"].values()]
    rows.append(["every flake traced, other seed", f"{traced.nanoseconds:,.0f}", *noise])
    yield from table(["choice", "ns", "count", "mean", "deviation", "distribution"], rows)


def law_tables(results: Results) -> Iterator[str]:
    for law in results.data["laws"]:
        yield f"{law['name'][0].upper()}{law['name'][1:]}:"
        yield ""
        rows = [
            [
                f"{row['count']:g}", off(row, "mean"), off(row, "variance"),
                *(f"{row[of]:.3g}".replace("-", "−") for of in ("skewness", "papers_skewness")),
                f"{row['distance']:.4f}", f"{row['noise']:.4f}",
            ]
            for row in law["rows"]
        ]  # fmt: skip
        yield from table(
            ["⟨N⟩", "mean off", "variance off", "skewness", "of the paper's sum", "distance",
             "noise"],
            rows,
        )  # fmt: skip


def off(row: dict, moment: str) -> str:
    error = f"{100 * (row[moment] - 1):+.2f} ± {100 * row[f'{moment}_error']:.2f} %"
    return error.replace("-", "−")


def moment_off(results: Results, moment: str) -> float:
    """What the draw's mean or variance is off the closed form, four standard errors in favour."""
    rows = [row for law in results.data["laws"] for row in law["rows"]]
    return max(max(abs(row[moment] - 1) - 4 * row[f"{moment}_error"], 0) for row in rows)


def report(results: Results) -> Iterator[str]:
    yield ACCURACY.mark
    yield ""
    yield "# Speed against accuracy"
    yield ""
    yield "`./paint accuracy` measured and wrote this page. Every line changes one thing of what "
    yield "ships and nothing else; bold is what ships."
    yield ""
    yield from in_short(results)
    yield "## The choices"
    yield ""
    yield "![Error against time for each choice](choices.png)"
    yield ""
    yield "![The exact picture, others, and their FLIP maps](pictures.png)"
    yield ""
    yield from scene_table(results)
    yield "## The law of the draw"
    yield ""
    yield (
        "The shader draws one sparkle, and all others as one sum. Here the green of a pixel is "
        "held against the sum of the paper, sparkle after sparkle: mean and variance off the "
        "closed form, with their standard errors, the skewness of both, and Kolmogorov's distance "
        "of the two laws, with the median that two samples of one law have."
    )
    yield ""
    yield "![Distance and skewness of the draw over the mean count](draws.png)"
    yield ""
    yield from law_tables(results)
    yield "## The depth models against traced flakes"
    yield ""
    yield (
        "Flakes are discs that hide one another; s is what the layer leaves of a sparkle. One "
        "thing is varied at a time about coverage 0.5, 20° in the plane of the mirror direction, "
        "tilt 0.15 and flakes of 20 µm in 30 µm of paint; three sparkles a pixel, under a light of "
        "0.1 rad that makes them many. The lacquer covers what sticks out of the layer."
    )
    yield ""
    yield "![Mean and fluctuation of the share, distance of the law](depth.png)"
    yield ""
    yield from depth_table(results)
    yield "## The model against a picture of traced flakes"
    yield ""
    yield from traced_tables(results)
    yield "## Every number"
    yield ""
    yield from choice_tables(results)
    yield "## How it is measured"
    yield ""
    scene = next(iter(results.scenes.values()))
    yield from (
        "Painted balls under the sun (“lamp”: under a light of 0.06 rad, as wide as the tilt), "
        f"{results.size} × {results.size} pixels, exact footprints.",
        "",
        "- *time*: processor time of one thread from geometry to radiance, without ray tracing. "
        "All choices in turn, in random order; the median of the rounds' ratios to what ships, the "
        "geometric mean over the scenes. Tables are made once for a million pixels. Times within "
        f"{results.tolerance:.1%} count as equal: the same draws by code compiled apart differ as "
        "much.",
        f"- *count, mean, deviation*: relative errors over {scene['draws']} draws of each of "
        f"{scene['judged']} pixels, from few to many sparkles; root mean square over the pixels, "
        "worst scene.",
        "- *distribution*: Wasserstein's distance of the radiance's law from the exact choice's, "
        "in standard deviations σ.",
        "- *FLIP, RMSE*: of the picture, worst scene; FLIP in sRGB at 67 pixels per degree, RMSE "
        "in linear light over the picture's mean.",
        "- Choices share the random numbers of their group's exact one, so these are errors and "
        "no noise. Where they cannot (another sum, another mean count) noise is in them, and the "
        "FLIP of two exact pictures stands beside in brackets.",
        "- *Dominated*: another choice is as fast, as exact in every scene, and better in one of "
        "them.",
    )


def make_bars(results: Results) -> list[bars.Bar]:
    found = []
    for group in judged(results):
        shipped = results.shipped(group)
        found.append(
            bars.at_most(f"accuracy, {group}: choices that dominate what ships",
                         float(shipped.dominated_by is not None), 0)
        )  # fmt: skip
    together = results.shipped(TOGETHER)
    for name, scene in results.scenes.items():
        flip = together.flip[name] / results.floor_flip[name]["own"]
        distance = together.errors[name]["distribution"] / scene["floor"]["own"]["distribution"]
        of = "of that between two seeds"
        found += [
            bars.at_most(f"accuracy, {name}: FLIP of what ships from everything exact, {of}",
                         flip, 1),
            # 1.18 was measured: the sum's shape errs where a pixel has a few sparkles.
            bars.at_most(f"accuracy, {name}: Wasserstein distance likewise, {of}", distance, 1.5),
        ]  # fmt: skip
    single = results.shipped(NUMBER_TYPE)
    narrow, wide = share_off(results, beyond_chance=True)
    squares = share_off(results, "square", beyond_chance=True)[0]
    of = f"mean of correlated off, beyond chance (p = {CHANCE:g})"
    return [
        *found,
        *(
            bars.at_most(f"accuracy, draw: {moment} off the closed form, beyond chance",
                         moment_off(results, moment), most)
            for moment, most in (("mean", 0.005), ("variance", 0.02))
        ),
        bars.at_most("accuracy, number type: RMSE of float, of the picture's mean",
                     max(single.rmse.values()), SCREEN_STEP),
        bars.at_most(f"accuracy, traced flakes up to as wide as the layer is thick: {of}",
                     max(narrow), MEAN_OFF),
        bars.at_most(f"accuracy, traced flakes that are wider: {of}", max(wide), MEAN_OFF_WIDE),
        bars.at_most("accuracy, traced flakes up to as wide as the layer is thick: mean square "
                     "likewise", max(squares), SQUARE_OFF),
        bars.at_most("accuracy, traced flakes: cases in which a law of the paper's is nearer than "
                     "correlated's by more than the noise", paper_nearer(results), 0),
    ]  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measurements", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()

    say("Comparing the pictures…")
    results = Results(arguments.measurements)
    with ACCURACY.fill(arguments.out) as folder:
        say("Drawing the plots…")
        plots.draw_all(results, folder)
        text = "\n".join(report(results)).rstrip() + "\n"
        (folder / REPORT).write_text(text)
    found = make_bars(results)
    if arguments.json:
        bars.write(found, arguments.json)
    for line in in_short(results):
        say(line)
    for bar in found:
        if not bar.holds:
            say(str(bar))
    say(f"The report is {arguments.out / REPORT}.")
    return 0 if all(bar.holds for bar in found) else 1


if __name__ == "__main__":
    run_program(main)
