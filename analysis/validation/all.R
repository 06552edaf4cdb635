# The same analyses in R: `Rscript all.R FOLDER`, where FOLDER holds the exports and results that
# `studies.sh` made. Called by `run`.

invisible(Sys.setlocale("LC_COLLATE", "C"))
# R warns of approximations by χ² and of half choices; the reports of both sides do.
options(warn = -1)
here <- dirname(sub("^--file=", "", grep("^--file=", commandArgs(FALSE), value = TRUE)))
for (file in c("table.R", "choices.R", "paired.R", "scaling.R", "categories.R", "ratings.R",
               "psychometric.R")) source(file.path(here, file))
folder <- commandArgs(TRUE)[1]
ours_of <- function(study) read_json(file.path(folder, paste0(study, ".json")))
answers_of <- function(study) read_export(file.path(folder, "exports", study))

for (study in c("nine", "repeated", "oneaxis", "unsure", "incomplete", "separated")) {
  ours <- ours_of(study)
  choices <- choices_of(answers_of(study))
  compare_preferences(study, ours, choices)
  compare_order(study, ours, choices)
  if (is.list(ours$grouping)) {
    scores <- compare_scores(study, ours, choices)
    compare_consistency(study, ours, scores)
    compare_equivalence(study, ours, choices)
  }
  if (is.list(ours$transitivity)) compare_transitivity(study, ours, choices)
  compare_agreement(study, ours, choices)
  if (study %in% c("nine", "oneaxis")) {
    compare_levels(study, ours, choices)
    clustered_by_level(study, ours, choices)
  }
  if (study != "separated") clustered_by_item(study, ours, choices)
  scaling <- ours$scaling
  compare_scale(study, "Bradley–Terry:", scaling$bradley_terry, choices, "logit")
  compare_scale(study, "Thurstone V:", scaling$thurstone, choices, "probit")
  if (study %in% c("repeated", "incomplete")) {
    compare_profiles(study, "Bradley–Terry:", scaling$bradley_terry, choices, "logit")
    compare_profiles(study, "Thurstone V:", scaling$thurstone, choices, "probit")
  }
  if (study %in% c("unsure", "incomplete")) compare_davidson(study, scaling$davidson, choices)
  if (study %in% c("nine", "repeated")) compare_btmodel(study, scaling$bradley_terry, choices)
}

together <- c("repeated", "separated")
choices <- lapply(together, function(study) choices_of(answers_of(study)))
compare_groups("repeated + separated", ours_of("together"), do.call(rbind, choices),
               rep(together, vapply(choices, nrow, 0)))

compare_matching("matching", ours_of("matching"), answers_of("matching"))
compare_same_different("same", ours_of("same"), answers_of("same"))

# By other roads: the study `nine` as a table of pwcmp, and published votes.
pwcmp <- read.csv(file.path(folder, "exports", "pwcmp", "pwcmp.csv"))
i <- pmin(pwcmp$condition_A, pwcmp$condition_B)
choices <- data.frame(
  i, j = pmax(pwcmp$condition_A, pwcmp$condition_B),
  won = as.numeric((pwcmp$condition_A == i) == pwcmp$is_A_selected),
  observer = pwcmp$observer, set = paste(pwcmp$observer, pwcmp$session_id))
ours <- ours_of("pwcmp")[[1]]
compare_preferences("pwcmp", ours, choices)
compare_agreement("pwcmp", ours, choices)
compare_scale("pwcmp", "Bradley–Terry:", ours$scaling$bradley_terry, choices, "logit")
ours <- ours_of("votes")
compare_votes("mono-sampling", ours, ours$votes, ours$observers)

ours <- ours_of("ratings")
ratings <- read.csv(file.path(folder, "ratings.csv"))
compare_ratings("ratings", ours$ratings, ratings)
compare_histogram("ratings", ours$histogram, ratings)
compare_coarsest("ratings", ours$coarsest, ratings)
compare_law("points", ours_of("points")$fit, read.csv(file.path(folder, "points.csv")))
for (shape in c("logistic", "probit", "weibull")) {
  for (study in c("choice", "yesno")) {
    compare_psychometric(study, shape, ours_of(paste0(study, "-", shape)),
                         read.csv(file.path(folder, paste0(study, ".csv"))), if (study == "choice") 2 else 1)
  }
}

quit(status = if (print_differences()) 0 else 1)
