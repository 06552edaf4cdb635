# Ratings of simplified models, and the law of the level of detail.

compare_ratings <- function(study, ours, table) {
  same <- table$same
  n <- table$same + table$different
  image <- c("model", "r", "level_of_detail", "speed")
  place <- match(do.call(paste, table[image]), do.call(paste, lapply(image, function(name) field(ours, name))))
  ours <- ours[place]
  test <- function(f) mapply(f, same, n)
  compare(study, "ratings", field(ours, "rating"), same / n, "arithmetic", 1e-10)
  compare(study, "ratings: Wilson's interval", unlist(lapply(ours, `[[`, "wilson_95")),
          test(function(k, n) prop.test(k, n, correct = FALSE)$conf.int), "stats::prop.test", 1e-10, size = 1)
  compare(study, "ratings: Clopper and Pearson's interval", unlist(lapply(ours, `[[`, "clopper_pearson_95")),
          test(function(k, n) binom.test(k, n)$conf.int), "stats::binom.test", 1e-10, size = 1)
  above <- test(function(k, n) binom.test(k, n, 0.8, "greater")$p.value)
  compare(study, "ratings: p against 0.8, both tails", c(field(ours, "p_above"), field(ours, "p_below")),
          c(above, test(function(k, n) binom.test(k, n, 0.8, "less")$p.value)), "stats::binom.test", 1e-10)
  compare(study, "ratings: p above 0.8, Holm", field(ours, "p_above_holm"), p.adjust(above, "holm"),
          "stats::p.adjust", 1e-10)
}

# How many images of each r look like the original.
compare_histogram <- function(study, ours, table) {
  over <- tapply(table$same >= 0.8 * (table$same + table$different), table$r, sum)
  compare(study, "histogram for r", field(ours$bins, "over"), over, "base::tapply", 0)
}

# The coarsest level that reaches 0.8, by the ratings and by a logistic function of ln level.
compare_coarsest <- function(study, ours, table) {
  found <- vapply(ours, function(one) {
    rows <- table$model == one$model & table$r == one$r & table$speed == one$speed
    of <- table[rows, ]
    of <- of[order(of$level_of_detail), ]
    reached <- which(of$same >= 0.8 * (of$same + of$different))
    model <- glm(cbind(same, different) ~ log(level_of_detail), binomial, of, control = exact_glm)
    c(if (length(reached) > 0 && reached[1] > 1) of$level_of_detail[reached[1]] else NA,
      unname(exp((qlogis(0.8) - coef(model)[1]) / coef(model)[2])), unname(coef(model)), deviance(model))
  }, numeric(5))
  known <- !is.na(found[1, ])
  compare(study, "coarsest levels by the point rule", field(ours[known], "point"), found[1, known], "definition", 0)
  smooth <- vapply(ours, function(one) is.list(one$smoothed), TRUE)
  compare(study, "coarsest levels by a logistic function", field(ours[smooth], "smoothed", "level"), found[2, smooth],
          "stats::glm", 1e-5)
  compare(study, "logistic function: coefficients, deviance",
          vapply(ours[smooth], function(one) unlist(one$smoothed[c("intercept", "slope", "deviance")]), numeric(3)),
          found[3:5, smooth], "stats::glm", 1e-5)
}

# ρ = 1/(σ₁ v + σ₂) by least squares.
compare_law <- function(study, ours, points) {
  start <- coef(lm(1 / frequency ~ speed, points))
  model <- nls(frequency ~ 1 / (s1 * speed + s2), points, start = list(s1 = start[[2]], s2 = start[[1]]),
               algorithm = "port", control = nls.control(tol = 1e-12, warnOnly = TRUE, scaleOffset = 1e-12))
  s <- summary(model)
  both <- list(ours$sigma_1, ours$sigma_2)
  by <- "stats::nls"
  compare(study, "σ₁ and σ₂", field(both, "estimate"), coef(model), by, 1e-5)
  compare(study, "σ₁ and σ₂, SE", field(both, "se"), s$coefficients[, 2], by, 1e-5)
  compare(study, "σ₁ and σ₂, covariance", unlist(ours$covariance), vcov(model), by, 1e-5)
  compare(study, "residual sum of squares, residual SE, log-likelihood, AIC",
          c(ours$rss, ours$residual_se, ours$log_likelihood, ours$aic),
          c(deviance(model), s$sigma, logLik(model), AIC(model)), by, 1e-5)
  total <- sum((points$frequency - mean(points$frequency))^2)
  compare(study, "R²", ours$r_squared, 1 - deviance(model) / total, by, 1e-5)
  half <- qt(0.975, df.residual(model)) * s$coefficients[, 2]
  compare(study, "σ₁ and σ₂, Wald intervals", unlist(lapply(both, `[[`, "wald_95")),
          rbind(coef(model) - half, coef(model) + half), by, 1e-5)
  # confint interpolates its profile with splines; the exact one solves for the sum of squares.
  compare(study, "σ₁ and σ₂, profile intervals", unlist(lapply(both, `[[`, "profile_95")),
          t(suppressMessages(confint(model))), "stats::confint", 1e-3)
  most <- deviance(model) * (1 + qt(0.975, df.residual(model))^2 / df.residual(model))
  least <- function(k, value) optimize(function(other) {
    sigma <- replace(rep(other, 2), k, value)
    sum((points$frequency - 1 / (sigma[1] * points$speed + sigma[2]))^2)
  }, coef(model)[3 - k] * c(0.01, 10), tol = 1e-12)$objective
  bounds <- vapply(1:2, function(k) {
    rise <- function(value) least(k, value) - most
    at <- coef(model)[k]
    step <- 3 * half[k]
    c(uniroot(rise, c(max(at - step, at / 20), at), tol = 1e-11)$root,
      uniroot(rise, c(at, at + step), tol = 1e-11)$root)
  }, c(0, 0))
  compare(study, "σ₁ and σ₂, profile intervals", unlist(lapply(both, `[[`, "profile_95")), bounds,
          "stats::optimize, stats::uniroot", 1e-5)
}
