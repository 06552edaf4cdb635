# Preferences: percentages and their tests, groups of scores, consistency, agreement, order, equivalence.

# A list of shares against R's tests of one binomial share.
compare_shares <- function(study, what, ours, chosen, trials) {
  study <- paste0(study, ", ", what)
  test <- function(f) mapply(f, chosen, trials)
  ends <- function(list, name) unlist(lapply(list, `[[`, name))
  compare(study, "share in percent", field(ours, "percent"), 100 * chosen / trials, "arithmetic", 1e-10)
  compare(study, "share: Wilson's interval", ends(ours, "wilson_95"),
          test(function(k, n) prop.test(k, n, correct = FALSE)$conf.int), "stats::prop.test", 1e-10,
          size = 1)
  compare(study, "share: Clopper and Pearson's interval", ends(ours, "clopper_pearson_95"),
          test(function(k, n) binom.test(k, n)$conf.int), "stats::binom.test", 1e-10, size = 1)
  compare(study, "share: χ²", field(ours, "chi2"),
          test(function(k, n) chisq.test(c(k, n - k))$statistic), "stats::chisq.test", 1e-10,
          size = pmax(1, field(ours, "chi2")))
  compare(study, "share: p of χ²", field(ours, "p_chi2"),
          test(function(k, n) chisq.test(c(k, n - k))$p.value), "stats::chisq.test", 1e-10)
  yates <- function(part) test(function(k, n) prop.test(k, n, correct = TRUE)[[part]])
  compare(study, "share: χ² with Yates's correction", field(ours, "chi2_corrected"), yates("statistic"),
          "stats::prop.test", 1e-10, size = pmax(1, yates("statistic")))
  compare(study, "share: p of χ² with Yates's correction", field(ours, "p_chi2_corrected"), yates("p.value"),
          "stats::prop.test", 1e-10)
  compare(study, "share: exact p", field(ours, "p_binomial"),
          test(function(k, n) binom.test(k, n)$p.value), "stats::binom.test", 1e-10)
}

compare_preferences <- function(study, ours, choices) {
  judged <- complete_of(choices)
  items <- ours$items
  wins <- wins_of(judged, items)
  votes <- rowSums(wins)
  trials <- wins + t(wins)
  compare(study, "votes", ours$votes, votes, "base::table", 0)
  compare(study, "preference matrix", unlist(ours$matrix), t(wins), "base::table", 0)
  compare_shares(study, "stimuli", ours$preference, votes, rowSums(trials))
  compare_shares(study, "pairs", ours$pairs, wins[places(ours$pairs)], trials[places(ours$pairs)])
}

places <- function(pairs, other = "over") cbind(field(pairs, "item"), field(pairs, other))

# Groups by the score difference R_c (David 1988) and the test of equal scores, from votes by m observers.
compare_votes <- function(study, ours, votes, m) {
  t <- length(votes)
  alpha <- ours$grouping$alpha
  tail_by_definition <- function(q) {
    within <- function(z) dnorm(z) * (pnorm(z + q) - pnorm(z))^(t - 1)
    1 - t * integrate(within, -9, 9, rel.tol = 1e-12, subdivisions = 1000)$value
  }
  w <- uniroot(function(q) tail_by_definition(q) - alpha, c(1, 9), tol = 1e-13)$root
  compare(study, "W, quantile of the range", ours$grouping$w, w, "definition by stats::integrate", 1e-9)
  compare(study, "W, quantile of the range", ours$grouping$w, qtukey(1 - alpha, t, Inf), "stats::qtukey", 1e-4)
  r <- 1
  while (ptukey((2 * r - 0.5) / sqrt(m * t), t, Inf, lower.tail = FALSE) > alpha) r <- r + 1
  compare(study, "R_c", ours$grouping$r_c, r, "stats::ptukey", 0)
  last <- vapply(votes, function(v) max(which(votes > v - r)), 0)
  starts <- which(!duplicated(last))
  ends <- lapply(ours$grouping$groups, function(group) match(group[c(1, length(group))], ours$items))
  compare(study, "groups, first and last stimulus", unlist(ends), rbind(starts, last[starts]), "definition", 0)
  d <- 4 * (sum(votes^2) - t * m^2 * (t - 1)^2 / 4) / (m * t)
  compare(study, "D of equal scores", ours$score_equality$d, d, "definition", 1e-9)
  compare(study, "p of D", ours$score_equality$p, pchisq(d, t - 1, lower.tail = FALSE), "stats::pchisq", 1e-9)
}

# The same from choices, and Friedman's test; the score of each stimulus (column) in each set (row).
compare_scores <- function(study, ours, choices) {
  judged <- complete_of(choices)
  scores <- do.call(rbind, lapply(split(judged, judged$set), function(set) rowSums(wins_of(set, ours$items))))
  compare_votes(study, ours, colSums(scores), nrow(scores))
  f <- friedman.test(scores)
  compare(study, "Friedman's χ²", ours$friedman$chi2, f$statistic, "stats::friedman.test", 1e-9)
  compare(study, "p of Friedman's χ²", ours$friedman$p, f$p.value, "stats::friedman.test", 1e-9)
  w <- f$statistic / (nrow(scores) * (ncol(scores) - 1))
  compare(study, "Kendall's W", ours$friedman$w, w, "stats::friedman.test", 1e-9)
  scores
}

# Circular triads, ζ, their χ² and, where all tournaments can be listed, the exact p.
compare_consistency <- function(study, ours, scores) {
  t <- ncol(scores)
  d <- choose(t, 3) - rowSums(choose(scores, 2))
  most <- if (t %% 2 == 1) (t^3 - t) / 24 else (t^3 - 4 * t) / 24
  ours <- ours$consistency
  compare(study, "circular triads per observer", sort(field(ours$per_observer, "circular_triads")), sort(d),
          "definition", 0)
  compare(study, "ζ per observer", sort(field(ours$per_observer, "zeta")), sort(1 - d / most), "definition",
          1e-10, size = 1)
  compare(study, "ζ pooled and its mean", c(ours$zeta, ours$zeta_mean), rep(mean(1 - d / most), 2),
          "definition", 1e-10)
  df <- t * (t - 1) * (t - 2) / (t - 4)^2
  chi2 <- function(d) 8 / (t - 4) * (choose(t, 3) / 4 - d - 0.5) + df
  # The sum of the triads is one whole number, corrected once.
  once <- sum(chi2(d)) + (length(d) - 1) * 4 / (t - 4)
  compare(study, "χ² of ζ, pooled", c(ours$chi2, ours$df), c(once, length(d) * df), "definition", 1e-10)
  compare(study, "p of χ² of ζ, per observer", sort(field(ours$per_observer, "p_chi2")),
          sort(pchisq(chi2(d), df, lower.tail = FALSE)), "stats::pchisq", 1e-10)
  if (t > 6) return()
  # Every tournament: bit by bit, who wins each pair.
  pairs <- combn(t, 2)
  all <- matrix(0, 2^ncol(pairs), t)
  for (pair in seq_len(ncol(pairs))) {
    bit <- bitwAnd(seq_len(nrow(all)) - 1, 2^(pair - 1)) > 0
    all[, pairs[1, pair]] <- all[, pairs[1, pair]] + bit
    all[, pairs[2, pair]] <- all[, pairs[2, pair]] + !bit
  }
  law <- tabulate(1 + choose(t, 3) - rowSums(choose(all, 2)), most + 1) / nrow(all)
  compare(study, "exact p of ζ, per observer", sort(field(ours$per_observer, "p")), sort(cumsum(law)[d + 1]),
          "all tournaments", 1e-10)
  pooled <- Reduce(convolved, rep(list(law), length(d)))
  compare(study, "exact p of ζ, pooled", ours$p, sum(pooled[seq_len(sum(d) + 1)]), "all tournaments", 1e-10)
}

# The law of a sum, as counts from 0.
convolved <- function(x, y) {
  sum <- numeric(length(x) + length(y) - 1)
  for (i in seq_along(x)) sum[i + seq_along(y) - 1] <- sum[i + seq_along(y) - 1] + x[i] * y
  sum
}

# Kendall's u with its tests.
compare_agreement <- function(study, ours, choices) {
  wins <- wins_of(complete_of(choices))
  t <- nrow(wins)
  judged <- (wins + t(wins))[upper.tri(wins)]
  sigma <- sum(choose(wins, 2))
  ours <- ours$agreement
  compare(study, "u and Σ", c(ours$u, ours$sigma), c(2 * sigma / sum(choose(judged, 2)) - 1, sigma),
          "definition", 1e-9)
  # Each pair's law of agreeing pairs of judgements, convolved.
  law <- 1
  for (m in judged) {
    of_pair <- numeric(choose(m, 2) + 1)
    for (k in 0:m) {
      place <- 1 + choose(k, 2) + choose(m - k, 2)
      of_pair[place] <- of_pair[place] + dbinom(k, m, 0.5)
    }
    law <- convolved(law, of_pair)
  }
  compare(study, "exact p of u", ours$p_exact, sum(rev(law[(sigma + 1):length(law)])),
          "convolution of stats::dbinom", 1e-9)
  m <- judged[1]
  if (any(judged != m)) return()
  smallest <- if (m %% 2 == 1) -1 / m else -1 / (m - 1)
  compare(study, "smallest u", ours$u_min, smallest, "definition", 1e-10)
  df <- choose(t, 2) * m * (m - 1) / (m - 2)^2
  chi2 <- function(sigma) 4 / (m - 2) * (sigma - choose(t, 2) * choose(m, 2) * (m - 3) / (m - 2) / 2)
  compare(study, "χ² of u, plain and corrected, df", c(ours$chi2, ours$chi2_corrected, ours$df),
          c(chi2(sigma), chi2(sigma - 1), df), "definition", 1e-9)
  compare(study, "p of χ² of u, plain and corrected", c(ours$p, ours$p_corrected),
          pchisq(chi2(sigma - 0:1), df, lower.tail = FALSE), "stats::pchisq", 1e-9)
}

# Violations of weak, moderate and strong stochastic transitivity (Tversky 1969).
compare_transitivity <- function(study, ours, choices) {
  wins <- wins_of(complete_of(choices))
  p <- wins / (wins + t(wins))
  orders <- list(c(1, 2, 3), c(1, 3, 2), c(2, 1, 3), c(2, 3, 1), c(3, 1, 2), c(3, 2, 1))
  counts <- combn(nrow(p), 3, function(triple) {
    if (anyNA(p[triple, triple][upper.tri(diag(3))])) return(rep(FALSE, 3))
    violated <- vapply(orders, function(order) {
      x <- triple[order]
      steps <- c(p[x[1], x[2]], p[x[2], x[3]])
      if (any(steps < 0.5)) return(rep(NA, 3))
      p[x[1], x[3]] < c(0.5, min(steps), max(steps))
    }, rep(NA, 3))
    violated[, which.min(colSums(violated))]
  })
  compare(study, "transitivity, weak, moderate, strong",
          vapply(ours$transitivity[c("weak", "moderate", "strong")], `[[`, 0, "violations"), rowSums(counts),
          "definition", 0)
}

# What is shown first.
compare_order <- function(study, ours, choices) {
  ours <- ours$order_effects
  decided <- choices[!is.na(choices$won), ]
  # Pairs that came in one order only do not tell order from preference.
  orders <- tapply(decided$first, paste(decided$i, decided$j), function(x) length(unique(x)))
  decided <- decided[orders[paste(decided$i, decided$j)] == 2, ]
  chosen <- decided$first == (decided$won == 1)
  compare_shares(study, "shown first", list(ours$first_chosen), sum(chosen), length(chosen))
  p <- vapply(ours$pairs, function(pair) {
    of <- decided[decided$i == pair$item & decided$j == pair$other, ]
    fisher.test(factor(of$first, c(TRUE, FALSE)), factor(of$won, 0:1))$p.value
  }, 0)
  compare(study, "order within pairs, p", field(ours$pairs, "p"), p, "stats::fisher.test", 1e-9)
  compare(study, "order within pairs, Holm", field(ours$pairs, "p_holm"), p.adjust(p, "holm"),
          "stats::p.adjust", 1e-9)
  by <- tapply(chosen, decided$observer, function(x) binom.test(sum(x), length(x))$p.value)
  by <- p.adjust(by[field(ours$observers, "observer")], "holm")
  compare(study, "order by observer, Holm", field(ours$observers, "p_holm"), by, "stats::p.adjust", 1e-9)
}

# Two one-sided tests of each pair of a group.
compare_equivalence <- function(study, ours, choices) {
  wins <- wins_of(complete_of(choices))
  ours <- ours$equivalence
  at <- places(ours, "other")
  margin <- ours[[1]]$margin
  level <- ours[[1]]$level
  k <- wins[at]
  n <- k + wins[at[, 2:1]]
  p <- mapply(function(k, n) max(binom.test(k, n, 0.5 - margin, "greater")$p.value,
                                 binom.test(k, n, 0.5 + margin, "less")$p.value), k, n)
  compare(study, "equivalence, p", field(ours, "p"), p, "stats::binom.test", 1e-10)
  compare(study, "equivalence, Holm", field(ours, "p_holm"), p.adjust(p, "holm"), "stats::p.adjust", 1e-10)
  compare(study, "equivalence, interval", unlist(lapply(ours, `[[`, "interval")),
          mapply(function(k, n) binom.test(k, n, conf.level = level)$conf.int, k, n), "stats::binom.test",
          1e-10, size = 1)
}

# Levels of each axis: the pairs that differ in it alone, and all that differ in it.
compare_levels <- function(study, ours, choices) {
  judged <- complete_of(choices)
  parts <- strsplit(c(judged$i, judged$j), "-", fixed = TRUE)
  parts <- array(unlist(parts), c(length(parts[[1]]), nrow(judged), 2))
  differ <- parts[, , 1] != parts[, , 2]
  winner <- ifelse(judged$won == 1, 1, 2)
  count <- function(level, over, among) {
    axis <- which(apply(parts == level, 1, any))
    rows <- which(differ[axis, ] & among)
    levels <- cbind(parts[axis, , 1], parts[axis, , 2])[rows, , drop = FALSE]
    has <- if (is.null(over)) rowSums(levels == level) > 0
           else rowSums(levels == level) > 0 & rowSums(levels == over) > 0
    c(sum(levels[cbind(seq_along(rows), winner[rows])][has] == level), sum(has))
  }
  shares <- vapply(ours$levels$shares, function(one) count(one$level, NULL, TRUE), c(0, 0))
  compare_shares(study, "levels", ours$levels$shares, shares[1, ], shares[2, ])
  alone <- vapply(ours$levels$alone, function(one) count(one$level, one$over, colSums(differ) == 1), c(0, 0))
  compare_shares(study, "levels, all else equal", ours$levels$alone, alone[1, ], alone[2, ])
  p <- apply(alone, 2, function(x) binom.test(x[1], x[2])$p.value)
  compare(study, "levels, Holm", field(ours$levels$alone, "p_holm"), p.adjust(p, "holm"),
          "stats::p.adjust", 1e-10)
  compare(study, "levels, Benjamini and Hochberg", field(ours$levels$alone, "p_benjamini_hochberg"),
          p.adjust(p, "BH"), "stats::p.adjust", 1e-10)
}

# The logistic model with observers as clusters: glm, and the jackknife over observers in one step.
compare_clustered <- function(study, what, ours, choices, x) {
  study <- paste0(study, ", ", what)
  choices$y <- ifelse(is.na(choices$won), 0.5, choices$won)
  model <- glm(choices$y ~ 0 + x, family = binomial, control = exact_glm)
  beta <- coef(model)
  p <- fitted(model)
  information <- crossprod(x, p * (1 - p) * x)
  observers <- split(seq_len(nrow(x)), choices$observer)
  steps <- vapply(observers, function(rows) {
    own <- x[rows, , drop = FALSE]
    others <- information - crossprod(own, p[rows] * (1 - p[rows]) * own)
    solve(others, crossprod(own, choices$y[rows] - p[rows]))
  }, beta)
  steps <- matrix(steps, length(beta))
  g <- length(observers)
  clustered <- (g - 1) / g * tcrossprod(steps)
  contrast <- vapply(ours$contrasts, function(one) {
    (colnames(x) == one$item) - (colnames(x) == one$over)
  }, beta)
  contrast <- matrix(contrast, length(beta))
  estimate <- drop(beta %*% contrast)
  se <- function(v) sqrt(colSums(contrast * (v %*% contrast)))
  compare(study, "clustered model: logits", field(ours$contrasts, "estimate"), estimate, "stats::glm",
          1e-6, size = max(estimate))
  compare(study, "clustered model: naive SE", field(ours$contrasts, "se_naive"), se(solve(information)),
          "stats::glm", 1e-6)
  compare(study, "clustered model: SE", field(ours$contrasts, "clustered", "se"), se(clustered),
          "glm, jackknife over observers", 1e-6)
  t <- estimate / se(clustered)
  p <- 2 * pt(-abs(t), g - 1)
  compare(study, "clustered model: p, Holm", field(ours$contrasts, "clustered", "p_holm"),
          p.adjust(p, "holm"), "stats::pt, stats::p.adjust", 1e-5)
  if (length(ours$tests) == 1) {
    q <- length(beta)
    f <- (g - q) / (q * (g - 1)) * drop(beta %*% solve(clustered, beta))
    compare(study, "clustered model: F of all and its p", c(ours$tests[[1]]$test$f, ours$tests[[1]]$test$p),
            c(f, pf(f, q, g - q, lower.tail = FALSE)), "Hotelling's T², stats::pf", 1e-5)
  }
}

exact_glm <- glm.control(epsilon = 1e-14, maxit = 100)

clustered_by_item <- function(study, ours, choices) {
  items <- items_of(choices)
  x <- differences_of(choices, items)
  colnames(x) <- items
  compare_clustered(study, "stimuli", ours$clustered_items, choices, x[, -1])
}

clustered_by_level <- function(study, ours, choices) {
  levels <- function(ids) do.call(rbind, strsplit(ids, "-", fixed = TRUE))
  i <- levels(choices$i)
  j <- levels(choices$j)
  columns <- lapply(seq_len(ncol(i)), function(axis) {
    names <- sort(unique(c(i[, axis], j[, axis])))[-1]
    x <- outer(i[, axis], names, "==") - outer(j[, axis], names, "==")
    colnames(x) <- names
    x
  })
  compare_clustered(study, "levels", ours$clustered_levels, choices, do.call(cbind, columns))
}

# Two studies as two groups of observers: every way to form groups of these sizes.
compare_groups <- function(study, ours, choices, group) {
  ours <- Filter(function(trait) trait$name == "study", ours$observer_groups)[[1]]$comparison
  items <- items_of(choices)
  won <- ifelse(is.na(choices$won), 0.5, choices$won)
  share <- function(item, who) {
    of <- who & (choices$i == item | choices$j == item)
    mean(ifelse(choices$i == item, won, 1 - won)[of])
  }
  person <- paste(group, choices$observer)
  people <- sort(unique(person))
  shares <- sapply(items, function(item) sapply(people, function(who) share(item, person == who)))
  labels <- sub(" .*", "", people)
  first <- labels == labels[1]
  centred <- scale(shares, scale = FALSE)
  spread <- function(rows) {
    colSums(centred[rows, , drop = FALSE])^2 / length(rows) +
      colSums(centred[-rows, , drop = FALSE])^2 / (nrow(centred) - length(rows))
  }
  every <- combn(length(people), sum(first), spread)
  observed <- spread(which(first))
  at_least <- function(found, observed) mean(found >= observed * (1 - 1e-9) - 1e-9)
  p <- vapply(seq_along(items), function(k) at_least(every[k, ], observed[k]), 0)
  of_items <- Filter(function(one) !one$level, ours$shares)
  compare(study, "groups: permutation p of stimuli", field(of_items, "p"), p[match(field(of_items, "item"), items)],
          "every grouping, utils::combn", 1e-12)
  compare(study, "groups: permutation p of all", ours$overall$p, at_least(colSums(every), sum(observed)),
          "every grouping, utils::combn", 1e-12)
  fisher <- vapply(ours$pairs, function(pair) {
    of <- choices$i == pair$item & choices$j == pair$over & !is.na(choices$won)
    fisher.test(group[of], choices$won[of])$p.value
  }, 0)
  compare(study, "groups: p of pairs", field(ours$pairs, "p"), fisher, "stats::fisher.test", 1e-9)
  decided <- !is.na(choices$won)
  by_group <- sapply(unique(labels), function(g) sapply(items, share, group == g & decided))
  compare(study, "groups: correlation of shares", ours$correlations[[1]]$r, cor(by_group[, 1], by_group[, 2]),
          "stats::cor", 1e-9)
}
