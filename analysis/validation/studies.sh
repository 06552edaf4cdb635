# Made-up studies: a tiny grid, a protocol per task, simulated observers, and tables. Called by `run` in an
# empty folder, with the program in $shutterlab and the folder of published votes in $published.
# shellcheck shell=bash
: "${shutterlab:?}" "${published:?}"

cat > grid.toml <<'TOML'
schema = 1
name = "validation"
title = "Thirty stimuli of two frames: only their names matter here"
scene = "rolling-sphere"
method = "distribution-ray-tracing"
trajectory = "wrap"
seed = 2012
sampler = "sobol"
sampling = "nested"

[image]
width_px = 16
height_px = 9
fps = 30.0
frames = 2
exposure_stops = 0.0
transfer = "srgb"

[viewing]
image_width_deg = 14.4

[materials.checker]
kind = "checker"
cells = 8
light = 0.8
dark = 0.1

[axes.material]
M2 = "checker"

[axes.speed_deg_per_s]
S1 = 5.0
S2 = 10.0

[axes.shutter_open_fraction]
T1 = 0.0
T2 = 0.25
T3 = 0.5
T4 = 0.75
T5 = 1.0

[axes.samples]
A3 = 1
A4 = 4
A5 = 9
TOML

# Worths of the stimuli: the product of their levels' worths.
{
    echo item,worth
    for speed in S1 S2; do
        for shutter in T1:1 T2:1.4 T3:3 T4:2.2 T5:1.2; do
            for samples in A3:1 A4:1.9 A5:2.2; do
                factor=$([ $speed = S1 ] && echo 1.3 || echo 1)
                worth=$(awk "BEGIN { print ${shutter#*:} * ${samples#*:} * $factor }")
                echo "M2-$speed-${shutter%:*}-${samples%:*},$worth"
            done
        done
    done
} > worths.csv
# The same so far apart that some stimuli are always chosen.
awk -F, -v OFS=, 'NR > 1 { $2 = $2 ^ 6 } 1' worths.csv > far-apart.csv

"$shutterlab" render grid.toml -o stimuli --device cpu > rendering.txt 2>&1

# protocol NAME TASK STIMULI DESIGN [MORE]: TOML; STIMULI and DESIGN are keys of these tables.
protocol() {
    cat > "$1.protocol.toml" <<TOML
schema = 1
name = "$1"
title = "Made up: $1"
task = "$2"
question = "Which?"
seed = 1
${5-}
[stimuli]
$3
[design]
$4
[timeline]
fixation_s = 0.5
gap_s = 0.5
eye = "follow"
replays = true
[text]
instructions = "None."
after_practice = "None."
pause = "None."
end = "None."
TOML
}

# study NAME COUNT [SORT]: COUNT simulated observers answer NAME; SORT is further keys of the cohort.
study() {
    cat > "$1.cohort.toml" <<TOML
schema = 1
seed = 5
[[observers]]
name = "made-up"
count = $2
code_prefix = "S"
$3
TOML
    "$shutterlab" run "$1.protocol.toml" --stimuli stimuli --study "studies/$1" --cohort "$1.cohort.toml"
    "$shutterlab" export "studies/$1/simulated" --to csv -o "exports/$1"
    "$shutterlab" analyze "studies/$1/simulated" --json > "$1.json"
}

people='model = { kind = "bradley-terry", worths = "worths.csv", spread = 0.6 }
lapse_rate = 0.03'
nine='speed = ["S2"]
shutter = ["T3", "T4", "T5"]
samples = ["A3", "A4", "A5"]'
five='speed = ["S2"]
shutter = ["T1", "T2", "T3", "T4", "T5"]
samples = ["A4"]'
all='pairs = "all"
repetitions = 1'

protocol nine 2afc "$nine" "$all"
study nine 21 "$people"
protocol repeated 2afc "$five" 'pairs = "all"
repetitions = 2'
study repeated 12 "$people
side_bias = 0.25"
protocol unsure 2afc "$five" 'pairs = "all"
repetitions = 2' 'not_sure = "I cannot tell"'
study unsure 15 "$people
not_sure_band = 0.15"
protocol incomplete 2afc "$five" "$all" 'not_sure = "I cannot tell"'
study incomplete 9 "$people
not_sure_band = 0.9"
protocol separated 2afc "$five" "$all"
study separated 5 'model = { kind = "bradley-terry", worths = "far-apart.csv", spread = 0.3 }'
protocol oneaxis 2afc 'speed = ["S1", "S2"]
shutter = ["T3", "T4", "T5"]
samples = ["A3", "A5"]' 'pairs = "one-axis"
repetitions = 1'
study oneaxis 18 "$people"
protocol matching matching "$five" 'pairs = "all"
repetitions = 2'
study matching 14 "$people"
protocol same same-different 'speed = ["S1", "S2"]
shutter = ["T5"]
samples = ["A3", "A4", "A5"]' 'pairs = "ground-truth"
ground_truth = { samples = "A5" }
identical_pairs = 3
repetitions = 2'
study same 16 'model = { kind = "bradley-terry", worths = "far-apart.csv", spread = 0.4, false_alarm_rate = 0.2 }'
"$shutterlab" analyze studies/repeated/simulated studies/separated/simulated --json > together.json

# The choices of one study as a table of pwcmp; published votes.
"$shutterlab" export studies/nine/simulated --to pwcmp -o exports/pwcmp
"$shutterlab" analyze exports/pwcmp/pwcmp.csv --json > pwcmp.json
"$shutterlab" analyze --votes "$published/mono-sampling.csv" --observers 20 --json > votes.json

# Ratings by 20 observers that scatter about a logistic function of ln level; points that scatter about a
# law; answers by level in a forced choice, and to yes or no.
awk 'BEGIN {
    OFS = ","
    print "model", "r", "level_of_detail", "speed", "same", "different", "frequency"
    for (model = 1; model <= 3; model++) for (r = 2; r <= 6; r += 2) for (speed = 5; speed <= 20; speed *= 2)
        for (level = 0.01; level <= 0.65; level *= 2) {
            place++
            eta = 6.2 + 0.3 * model + 0.08 * speed - 0.4 * (r - 4) ^ 2 / 4 + 2 * log(level)
            same = int(20 / (1 + exp(-eta)) + (place * 7) % 5 / 2)
            if (same > 20) same = 20
            print "model" model, r, level, speed, same, 20 - same, 0.5 * sqrt(level)
        }
}' > ratings.csv
"$shutterlab" fit r ratings.csv --velocity-unit degrees-per-second --json > ratings.json

cat > points.csv <<'CSV'
speed,frequency
1,0.129
2,0.071
3,0.0441
4,0.0352
6,0.0231
8,0.0164
12,0.0119
16,0.0083
CSV
"$shutterlab" fit lod --points points.csv --velocity-unit degrees-per-second \
    --frequency-unit per-perimeter-pixel --json > points.json

cat > choice.csv <<'CSV'
level,chosen,trials
0.5,21,40
1,24,40
1.5,23,40
2,29,40
3,33,40
4,35,40
6,39,40
8,40,40
CSV
cat > yesno.csv <<'CSV'
level,chosen,trials
0.5,2,40
1,5,40
1.5,7,38
2,15,40
3,24,40
4,31,41
6,38,40
8,39,40
CSV
for shape in logistic probit weibull; do
    "$shutterlab" fit psychometric choice.csv --shape $shape --guess 0.5 --threshold 0.75 --json > choice-$shape.json
    "$shutterlab" fit psychometric yesno.csv --shape $shape --threshold 0.5 --json > yesno-$shape.json
done
